"""Documents that are wrong: all findings at once, each where the user wrote it."""

# ruff: noqa: E501  (a mistake and its finding stand on one line)

from dataclasses import replace

import pytest

from bt_manip.bt import (
    Action,
    AlwaysFailure,
    AlwaysSuccess,
    BehaviourRegistry,
    Dialect,
    Input,
    Status,
    load_tree,
    parse_tree,
)
from bt_manip.bt.loading import read_tree, read_tree_text
from bt_manip.exceptions import NodeError, TreeError


class Reach(Action):
    object = Input(str, doc="name of the object")
    height = Input(float, default=0.1)

    def update(self):
        return Status.SUCCESS


@pytest.fixture
def registry():
    return BehaviourRegistry([Reach])


def findings(text, registry, **options):
    return [str(problem) for problem in read_tree_text(text, registry, **options).problems]


def document(body, head='main_tree_to_execute="Main"', rest=""):
    return (
        f'<root BTCPP_format="4" {head}>\n'
        f'  <BehaviorTree ID="Main">\n'
        f"    {body}\n"
        f"  </BehaviorTree>{rest}\n</root>\n"
    )


@pytest.mark.parametrize(
    ("body", "finding"),
    [
        ("<Reech object='a'/>", "3:5: error: no node is named 'Reech'; did you mean 'Reach'?"),
        ("<Reach objekt='a' object='b'/>", "3:12: error: Reach has no port 'objekt'; did you mean 'object'?"),
        ("<Reach object='a' height='high'/>", "3:31: error: port 'height': 'high' is not a number; expected double, or an entry as {key}"),
        ("<Reach/>", "3:5: error: Reach needs the port 'object' of type std::string (name of the object)"),
        ("<BehaviorTree ID='V'><AlwaysSuccess/></BehaviorTree>", "3:5: error: a <BehaviorTree> cannot stand inside another"),
        ("<Action ID='Nope'/>", "3:13: error: no node is named 'Nope'"),
        ("<Action/>", "3:5: error: <Action> needs the attribute 'ID'"),
        ("<Sequence/>", "3:5: error: Sequence must have at least 1 child"),
        ("<Inverter/>", "3:5: error: Inverter must have exactly 1 child, not 0"),
        ("<Script code='x =='/>", "3:19: error: expected an operand at position 4, found ''"),
        ("<Reach object='a' _skipIf='1 +'/>", "3:32: error: _skipIf: expected an operand at position 3, found ''"),
        ("<SubTree ID='Other'/>", "3:14: error: no tree is named 'Other'; known: Main"),
        ("<SubTree ID='Main'/>", "3:14: error: trees contain each other in a circle: Main -> Main"),
        ("<SubTree ID='Main' _autoremap='yes'/>", "3:24: error: _autoremap: 'yes' is not a truth value (true, false, 1 or 0)"),
        ("<Main/>", "3:5: error: no node is named 'Main'; to tick the tree of that name write <SubTree ID=\"Main\"/>"),
        ("<IfThenElse><AlwaysSuccess/></IfThenElse>", "3:5: error: IfThenElse must have 2 or 3 children: a condition and 1 or 2 branches"),
        ("<Switch2 variable='1' case_1='1' case_2='2'><AlwaysSuccess/></Switch2>", "3:5: error: Switch2 must have 3 children, one for each case and one for all others; it has 1"),
        ("<Parallel success_count='3'><AlwaysSuccess/></Parallel>", "3:15: error: Parallel has 1 children: success_count=3 can never be reached"),
        ("<Sequence name='näme 名'><Nope/></Sequence>", "3:29: error: no node is named 'Nope'"),
        ("<Sequence><Sleep msec='{n}'/><Reach object='a' height='{n}'/></Sequence>", "3:60: error: the entry 'n' holds unsigned int, as it was declared first; the port 'height' of Reach::3 wants double"),
        ("<Sequence><SubTree ID='S' name='x'/><SubTree ID='S' name='x'/></Sequence>", "3:63: error: two sub-trees have the path 'x'; give one of them another name"),
        ("<LoopInt queue='1;x'><AlwaysSuccess/></LoopInt>", "3:21: error: port 'queue' of LoopInt::1: 'x' is not an integer"),
    ],
)  # fmt: skip
def test_a_mistake_is_found_where_it_stands(registry, body, finding):
    rest = "<BehaviorTree ID='S'><AlwaysSuccess/></BehaviorTree>" if "'S'" in body else ""
    assert f"<text>:{finding}" in findings(document(body, rest=rest), registry)


def test_all_mistakes_of_a_document_are_found_at_once(registry):
    body = "<Sequence><Reech/><Reach objekt='a'/><Script code='1 +'/><Nope/></Sequence>"

    with pytest.raises(TreeError) as error:
        parse_tree(document(body), registry)

    assert len(error.value.problems) == 5
    columns = [problem.place.column for problem in error.value.problems]
    assert columns == sorted(columns)
    assert str(error.value).count("\n") == 4


@pytest.mark.parametrize(
    ("text", "finding"),
    [
        ("", "1:1: error: the document is empty; expected <root>"),
        ("<root>", "1:1: error: <root> is not closed"),
        ("<root>\n  <a></b></root>", "2:6: error: expected </a> (opened at line 2), found </b>"),
        ("<root x=1/>", "1:7: error: attribute 'x' has no value in quotes"),
        ("<root x='1' x='2'/>", "1:13: error: attribute 'x' stands twice in <root>"),
        ("<root/><root/>", "1:8: error: a document has one root element; found another"),
        ("<!-- no end", "1:1: error: the comment is not closed"),
        ("hello", "1:1: error: text stands outside of the root element"),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><root/>", "1:1: error: document types and entities are not allowed in tree documents"),
        ("<tree/>", "1:1: error: the outermost element must be <root>; found <tree>"),
        ("<root/>", "1:1: error: which tree to run? <root> has no main_tree_to_execute, and 'run <text>:TREE' names one; trees that no other uses: none"),
        ("<root>\0</root>", "1:7: error: a NUL character is no part of XML"),
    ],
)  # fmt: skip
def test_what_is_no_document_is_refused(registry, text, finding):
    assert f"<text>:{finding}" in findings(text, registry)


def test_bytes_that_are_no_utf8_are_placed_and_a_missing_file_is_named(registry, tmp_path):
    file = tmp_path / "tree.xml"
    file.write_bytes(b"<root>\n  \xff</root>")

    with pytest.raises(TreeError, match=r"tree.xml:2:3: error: not UTF-8"):
        load_tree(file, registry)
    with pytest.raises(TreeError, match="nothing.xml: cannot be read: No such file"):
        load_tree(tmp_path / "nothing.xml", registry)


class TestIncludes:
    """Included files are read too, and their mistakes are shown in them."""

    @pytest.fixture
    def files(self, tmp_path):
        def write(**texts):
            for name, text in texts.items():
                (tmp_path / f"{name}.xml").write_text(text)
            return tmp_path / "main.xml"

        return write

    @pytest.mark.parametrize(
        ("main", "part", "place", "finding"),
        [
            (
                "<include path='part.xml'/>",
                "<BehaviorTree ID='Part'><Nope/></BehaviorTree>",
                "part.xml:2:25",
                "no node is named 'Nope'",
            ),
            (
                "<include path='part.xml'/>",
                "<include path='main.xml'/>",
                "part.xml:2:10",
                "files include each other in a circle",
            ),
            ("<include path='nothing.xml'/>", "", "main.xml:2:10", "the included file"),
            ("<include/>", "", "main.xml:2:1", "<include> needs the attribute 'path'"),
        ],
    )
    def test_a_mistake_is_shown_where_it_stands(
        self, registry, files, tmp_path, main, part, place, finding
    ):
        root = "<root BTCPP_format='4'>\n{}</root>".format
        problems = read_tree(files(main=root(main), part=root(part)), registry).problems
        start = f"{tmp_path / place}: error: {finding}"
        assert any(str(problem).startswith(start) for problem in problems)

    def test_a_chain_of_150_includes_is_one_error(self, registry, files, tmp_path):
        leaf = '<BehaviorTree ID="T"><AlwaysSuccess/></BehaviorTree>'
        for i in range(150):
            text = f'<root><include path="f{i + 1}.xml"/></root>' if i < 149 else f"<root>{leaf}"
            (tmp_path / f"f{i}.xml").write_text(text + "</root>" * (i == 149))

        (error,) = read_tree(tmp_path / "f0.xml", registry, library=True).errors
        assert str(error).endswith(
            "f99.xml:1:16: error: files include each other deeper than 100 levels"
        )
        assert read_tree(tmp_path / "f90.xml", registry).tree is not None

    def test_a_thousand_files_are_enough(self, registry, files):
        chain = {
            f"f{i}": f"<root><include path='f{i + 1}.xml'/><include path='f{i + 1}.xml'/></root>"
            for i in range(12)
        }
        main = files(main="<root><include path='f0.xml'/></root>", f12="<root/>", **chain)

        assert any("more than 1000 files" in str(p) for p in read_tree(main, registry).problems)

    def test_trees_of_other_files_can_be_given_without_an_include(self, registry, files, tmp_path):
        main = files(
            main=document("<SubTree ID='Part'/>"),
            part="<root><BehaviorTree ID='Part'><AlwaysSuccess/></BehaviorTree></root>",
        )
        tree = load_tree(main, registry, libraries=[tmp_path / "part.xml"])

        assert tree.tick().name == "SUCCESS"


class TestWarnings:
    """What is strange but not wrong."""

    def warnings(self, registry, body, **options):
        reading = read_tree_text(document(body, **options), registry)
        assert reading.errors == () and reading.tree is not None
        return [str(problem).removeprefix("<text>:") for problem in reading.warnings]

    @pytest.mark.parametrize(
        ("body", "rest", "warning"),
        [
            ("<AlwaysSuccess _skipif='true'/>", "", "3:20: warning: the attribute '_skipif' has no meaning; did you mean '_skipIf'?"),
            ("<Reach object='{cube}'/>", "", "3:20: warning: nothing writes the blackboard entry 'cube' that is read here"),
            ("<AlwaysSuccess/>", "\n  <BehaviorTree ID='Spare'><AlwaysSuccess/></BehaviorTree>", "5:17: warning: nothing uses the tree 'Spare' (Main runs)"),
            ("<AlwaysSuccess/>", "\n  <BehaviorTree ID='Main'><AlwaysFailure/></BehaviorTree>", "5:17: warning: tree 'Main' was defined before, at <text>:2:3; this definition counts"),
            ("<ReactiveSequence><Action ID='AlwaysSuccess'/></ReactiveSequence>", "", "3:23: warning: BehaviorTree.CPP refuses this form directly below a ReactiveSequence; there, write <AlwaysSuccess .../>"),
            ("<ScriptCondition code='1 < 2 && true'/>", "", "3:28: warning: other XML readers refuse '&' and '<' here; write '&amp;' and '&lt;'"),
        ],
    )  # fmt: skip
    def test_it_is_found_where_it_stands(self, registry, body, rest, warning):
        assert self.warnings(registry, body, rest=rest) == [warning]

    def test_attributes_of_editors_mean_something_to_them(self, registry):
        assert self.warnings(registry, "<AlwaysSuccess _uid='1' _collapsed='true'/>") == []

    @pytest.mark.parametrize("name", ["goal", "_gaol"])
    def test_a_mistyped_attribute_of_a_tree(self, registry, name):
        text = document("<AlwaysSuccess/>").replace("<BehaviorTree", f"<BehaviorTree {name}=''")
        (warning,) = read_tree_text(text, registry).warnings
        assert warning.message == f"the attribute '{name}' has no meaning; did you mean '_goal'?"

    @pytest.mark.parametrize(
        "body",
        [
            "<Sequence><Script code=\"c := 'a'\"/><Reach object='{c}'/></Sequence>",
            "<Sequence><SetBlackboard value='a' output_key='c'/><Reach object='{c}'/></Sequence>",
            "<LoopString queue='a' value='{c}'><Reach object='{c}'/></LoopString>",
            "<Sequence><SubTree ID='S' out='{c}'/><Reach object='{c}'/></Sequence>",
            "<Sequence><SubTree ID='S' _autoremap='1'/><Reach object='{out}'/></Sequence>",
        ],
    )
    def test_a_key_that_something_writes_is_fine(self, registry, body):
        rest = "<BehaviorTree ID='S'><Script code=\"out := 'a'\"/></BehaviorTree>"
        found = self.warnings(registry, body, rest=rest)
        assert [f for f in found if "nothing writes" in f] == []

    @pytest.mark.parametrize(
        "body",
        ["<Reach object='a' height='x'/>", "<BehaviorTree ID='V'><AlwaysFailure/></BehaviorTree>"],
    )
    def test_mistakes_in_trees_that_nothing_uses_are_errors(self, registry, body):
        rest = f"<BehaviorTree ID='Spare'>{body}</BehaviorTree>"
        reading = read_tree_text(document("<AlwaysSuccess/>", rest=rest), registry)
        assert len(reading.errors) == 1

    def test_the_same_name_shorthand_in_a_model_means_the_name(self, registry):
        tree = "<BehaviorTree ID='T'><AlwaysSuccess/></BehaviorTree>"
        port = "<input_port name='h' default='{=}'/>"
        model = f"<TreeNodesModel><SubTree ID='T'>{port}</SubTree></TreeNodesModel>"
        text = document("<SubTree ID='T' name='t'/>", rest=tree + model)
        reading = read_tree_text(text, registry)
        assert reading.tree.scopes["t"].remapped == {"h": "h"}
        assert "write {h}" in reading.warnings[0].message


class TestEngineMode:
    """Without the extra checks a document loads as in the engine, and fails at the same tick."""

    @pytest.mark.parametrize(
        "body",
        [
            "<Repeat><AlwaysSuccess/></Repeat>",
            "<IfThenElse><AlwaysSuccess/></IfThenElse>",
            "<Parallel success_count='2'><AlwaysSuccess/></Parallel>",
            "<Precondition if='true' else='NEVER'><AlwaysSuccess/></Precondition>",
        ],
    )
    def test_what_the_engine_finds_at_a_tick_is_found_at_a_tick(self, registry, body):
        with pytest.raises(TreeError):
            parse_tree(document(body), registry)
        tree = parse_tree(document(body), registry, strict=False)
        with pytest.raises(NodeError):
            tree.tick()

    def test_which_tree_runs(self, registry):
        one = "<root><BehaviorTree ID='Only'><AlwaysSuccess/></BehaviorTree></root>"
        nameless = "<root><BehaviorTree><AlwaysSuccess/></BehaviorTree></root>"
        two = document(
            "<AlwaysSuccess/>", rest="<BehaviorTree ID='B'><AlwaysFailure/></BehaviorTree>"
        )

        assert parse_tree(one, registry).tree_id == "Only"
        assert parse_tree(nameless, registry).tick().name == "SUCCESS"
        assert parse_tree(two, registry, main="B").tick().name == "FAILURE"
        with pytest.raises(TreeError, match="no tree is named 'C'"):
            parse_tree(two, registry, main="C")


class Shout(AlwaysSuccess):
    """A node of a dialect."""


LOUD = Dialect(
    "loud",
    nodes={"Shout": Shout, "Sleep": AlwaysFailure},
    attributes=frozenset({"_volume"}),
    spaces_in_names=True,
    double_quotes=True,
    recognises=lambda root, problems: any(e.name == "Shout" for e in root.iterate()),
    translate=lambda root, document, problems: [
        element.attributes.pop("loudly", None) for element in root.iterate()
    ],
)


class TestDialects:
    """A dialect that is made here; those of packages have their own tests."""

    TEXT = """<root BTCPP_format="4"><BehaviorTree ID="Pick One" _results="a">
      <Fallback _volume="11"><Sleep/><Script code="a := &quot;it's&quot;" loudly="yes"/><Shout/>
      </Fallback></BehaviorTree></root>"""

    @pytest.fixture
    def registry(self, registry):
        registry.register_dialect(LOUD)
        return registry

    @pytest.mark.parametrize("dialect", ["loud", "auto"])
    def test_its_documents_run_with_its_nodes_for_those_of_the_same_name(self, registry, dialect):
        reading = read_tree_text(self.TEXT, registry, dialect=dialect)
        assert reading.errors == ()
        assert reading.tree.tick().name == "SUCCESS"
        assert reading.tree.blackboard["a"] == "it's"

    def test_the_engine_refuses_them(self, registry):
        with pytest.raises(TreeError) as error:
            parse_tree(self.TEXT, registry)
        assert "the tree name 'Pick One' contains" in str(error.value)
        assert "no node is named 'Shout'; --dialect loud has it" in str(error.value)

    def test_an_unknown_dialect_offers_the_nearest_and_the_package(self, registry):
        with pytest.raises(TreeError, match="no dialect is named 'lout'; did you mean 'loud'"):
            parse_tree(self.TEXT, registry, dialect="lout")
        with pytest.raises(TreeError, match="it needs the package bt-manip-moveit-pro"):
            parse_tree(self.TEXT, registry, dialect="moveit-pro")

    def test_plain_documents_are_not_taken_for_it(self, registry):
        with pytest.raises(TreeError, match="single quotes"):
            parse_tree(document("<Script code='a := \"b\"'/>"), registry, dialect="auto")

    def test_its_libraries_have_sub_trees_that_the_documents_own_replace(self, registry, tmp_path):
        (tmp_path / "all.xml").write_text(
            '<root BTCPP_format="4"><BehaviorTree ID="A"><AlwaysFailure/></BehaviorTree>'
            '<BehaviorTree ID="B"><AlwaysFailure/></BehaviorTree></root>'
        )
        registry.register_dialect(replace(LOUD, libraries=(tmp_path,)))
        text = (
            '<root BTCPP_format="4" main_tree_to_execute="Main"><BehaviorTree ID="Main"><Sequence>'
            '<SubTree ID="A"/><Shout/><SubTree ID="B"/></Sequence></BehaviorTree>'
            '<BehaviorTree ID="A"><AlwaysSuccess/></BehaviorTree></root>'
        )
        tree = parse_tree(text, registry, dialect="auto")
        assert tree.tick().name == "FAILURE"
        assert [child.status.name for child in tree.root.children][::2] == ["SUCCESS", "FAILURE"]
        plain = text.replace("<Shout/>", "")
        with pytest.raises(TreeError, match="no tree is named 'B'"):
            parse_tree(plain, registry, dialect="auto")


@pytest.mark.parametrize(
    "body",
    [
        '<Sleep msec="{}"/>',
        '<Sleep msec="9{}"/>',
        '<Sleep {}="1"/>',
        "<{}/>",
        '<SubTree ID="{}"/>',
        '<Script code="{}"/>',
        '<Script code="a b {}"/>',
    ],
)
def test_long_names_and_values_are_cut_in_findings(registry, body):
    for text in ("x" * 10_000, "9" * 10_000):
        for finding in findings(document(body.format(text)), registry):
            assert len(finding) < 300
