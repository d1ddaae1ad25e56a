"""Documents, Python source and schemas that are written say the same as what was read."""

import sys
import types

import py_trees
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lxml import etree

from bt_manip.bt import (
    Action,
    AlwaysFailure,
    AlwaysSuccess,
    BehaviourRegistry,
    Comment,
    Fallback,
    Input,
    Inverter,
    Parallel,
    Repeat,
    Script,
    Sequence,
    Status,
    SubTree,
    Switch2,
    Tree,
    as_written,
    parse_tree,
    tree_to_xml,
)
from bt_manip.bt.loading import read_tree
from bt_manip.bt.xml.model import models_document
from bt_manip.bt.xml.schema import tree_schema
from bt_manip.bt.xml.source import Source, parse_source
from bt_manip.bt.xml.writer import write_source
from bt_manip.exceptions import TreeError
from bt_manip_convert import to_python
from tests.bt.conftest import models_of
from tests.support.corpus_leaves import corpus_registry


class Hover(Action):
    """Move the tool over an object."""

    object = Input(str, doc="name of the object")
    height = Input(float, default=0.4, doc="height over its centre [m]")

    def update(self):
        return Status.SUCCESS


class Mystery(Action):
    thing = Input(dict)

    def update(self):
        return Status.SUCCESS


REGISTRY = BehaviourRegistry([Hover, Mystery])

DOCUMENT = """\
<?xml version="1.0" encoding="UTF-8"?>
<!-- before -->
<root BTCPP_format="4" main_tree_to_execute="Main" project="mine">
  <!-- the main tree -->
  <BehaviorTree ID="Main" _description="all of it">
    <Sequence name="s">
      <!-- first -->
      <Hover object="{cube}" height="0.30" _uid="7"/>
      <Action ID="Hover" name="again" object="a &amp; b"/>
      <SubTree ID="Sub" name="x" p="{cube}" c="5" _autoremap="1" _skipIf="cube == &apos;&apos;"/>
      <Script code="a := &apos;two&#10;lines&apos;"><!-- inside --></Script>
    </Sequence>
  </BehaviorTree>

  <BehaviorTree ID="Sub">
    <AlwaysSuccess/>
    <!-- after -->
  </BehaviorTree>
  <TreeNodesModel>
    <SubTree ID="Sub">
      <input_port name="p" default="1">what it is</input_port>
    </SubTree>
  </TreeNodesModel>
</root>
<!-- the end -->
"""


def content(element):
    attributes = sorted((a.name, a.value) for a in element.attributes.values())
    inside = [
        content(item) if hasattr(item, "name") else item.text.strip() for item in element.content
    ]
    return element.name, attributes, inside


def test_a_document_in_clean_form_is_written_as_it_was():
    written = write_source(parse_source(DOCUMENT))

    assert written.replace("'", "&apos;").replace("&quot;", '"') == DOCUMENT


def test_writing_twice_changes_nothing(engine_facts):
    for file in sorted((engine_facts / "corpus").glob("*.xml")):
        try:
            source = parse_source(file.read_text(encoding="utf-8"))
        except TreeError:
            continue
        written = write_source(source)
        again = parse_source(written)
        assert content(again.root) == content(source.root)
        assert write_source(again) == written


def test_line_breaks_in_values_survive_other_readers():
    text = write_source(parse_source(DOCUMENT))
    script = etree.fromstring(text.encode()).find(".//Script")

    assert script.get("code") == "a := 'two\nlines'"


def test_a_long_tag_has_an_attribute_a_line():
    attributes = " ".join(f'a{i}="{"x" * 20}"' for i in range(5))
    written = write_source(parse_source(f"<root><b {attributes}/></root>"))

    assert max(map(len, written.splitlines())) < 100
    assert content(parse_source(written).root) == content(
        parse_source(f"<root><b {attributes}/></root>").root
    )


def test_nothing_of_the_corpus_is_lost_as_python_source(engine_facts, monkeypatch):
    module = types.ModuleType("corpus_leaves")
    registry = corpus_registry([])
    for name in registry.names(built_in=False):
        registry.get(name).__module__ = module.__name__
        setattr(module, name, registry.get(name))
    monkeypatch.setitem(sys.modules, module.__name__, module)
    count = 0
    for file in sorted((engine_facts / "corpus").glob("*.xml")):
        reading = read_tree(file, registry, strict=False)
        if reading.errors or reading.document is None:
            continue
        count += 1
        namespace = {}
        exec(compile(to_python(reading), "tree.py", "exec"), namespace)
        written = tree_to_xml(namespace["document"](), registry)
        assert content(parse_source(written).root) == content(reading.document.root), file
    assert count > 120


class TestTreesFromPython:
    """A tree that was built in Python becomes a document without loss."""

    TREE = staticmethod(
        lambda: Sequence(
            "pick",
            [
                Comment(" a word "),
                Hover(object="{cube}", height=0.25, skip_if="x > 3"),
                as_written(AlwaysSuccess(), tag="Action", attributes={"_uid": "4"}),
                SubTree("try it", Inverter(AlwaysFailure()), tree_id="Try", remap={"a": "{b}"}),
                Repeat("again", Parallel(AlwaysSuccess(), AlwaysSuccess()), num_cycles=2),
                Switch2([AlwaysSuccess() for _ in "abc"], variable="{v}", case_1="a", case_2="b"),
            ],
        )
    )  # fmt: skip

    def test_its_document_reads_as_the_same_tree(self):
        first = tree_to_xml(self.TREE(), REGISTRY, tree_id="Pick")
        tree = parse_tree(first, REGISTRY)

        assert tree_to_xml(tree.root, REGISTRY, tree_id="Pick") == first
        assert [node.path for node in tree.nodes] == [n.path for n in Tree(self.TREE()).nodes]
        assert "<!-- a word -->" in first and '<Action ID="AlwaysSuccess" _uid="4"/>' in first

    def test_every_node_without_a_form_in_xml_is_named(self):
        class Unknown(Action):
            """Be unknown."""

        tree = Sequence(Unknown("u"), py_trees.behaviours.Success("p"), Mystery(thing={}))

        with pytest.raises(TreeError) as error:
            tree_to_xml(tree, REGISTRY)
        assert len(error.value.problems) == 3
        assert "'u': " in str(error.value) and "Success is not registered" in str(error.value)
        assert "port 'thing': a dict cannot be written as text" in str(error.value)

    def test_a_tree_that_is_used_twice_is_written_once_and_another_cannot_share_its_id(self):
        def twice(other):
            return Sequence(
                SubTree("a", AlwaysSuccess(), tree_id="T"), SubTree("b", other, tree_id="T")
            )

        assert tree_to_xml(twice(AlwaysSuccess()), REGISTRY).count('<BehaviorTree ID="T">') == 1
        with pytest.raises(TreeError, match="two different trees are called 'T'"):
            tree_to_xml(twice(AlwaysFailure()), REGISTRY)


leaves = st.sampled_from(
    [
        lambda: AlwaysSuccess(),
        lambda: AlwaysFailure("no"),
        lambda: Script(code="x := x + 1; s := 'a < b && \"c\"'"),
        lambda: Hover(object="{cube}", height=0.125, failure_if="x > 2"),
    ]
)


@settings(max_examples=50, deadline=None)
@given(
    st.recursive(
        leaves.map(lambda make: make),
        lambda inner: st.tuples(
            st.sampled_from([Sequence, Fallback, Parallel]),
            st.lists(inner, min_size=1, max_size=3),
            st.one_of(st.none(), st.text(alphabet="ab <&>\"'\né", max_size=5)),
        ).map(lambda t: lambda: t[0](t[2], [make() for make in t[1]])),
        max_leaves=12,
    )
)
def test_write_then_read_gives_the_same_tree_and_the_same_run(make):
    def run(tree):
        tree.blackboard["x"] = 0
        return [(tree.tick().name, tree.blackboard["x"]) for _ in range(4)]

    written = tree_to_xml(make(), REGISTRY)
    tree = parse_tree(written, REGISTRY)

    assert tree_to_xml(tree.root, REGISTRY) == written
    assert run(tree) == run(Tree(make()))


@pytest.fixture(scope="module")
def schema():
    return etree.XMLSchema(etree.fromstring(tree_schema(REGISTRY).encode()))


class TestSchemas:
    """Schemas and models for editors."""

    def test_the_own_schema_takes_what_the_project_writes(self, schema):
        for text in (DOCUMENT, tree_to_xml(TestTreesFromPython.TREE(), REGISTRY, model=True)):
            schema.assertValid(etree.fromstring(write_source(parse_source(text)).encode()))

    @pytest.mark.parametrize(
        "body",
        [
            "<Nope/>",
            "<Hover/>",
            "<Hover object='a' height='high'/>",
            "<Inverter/>",
            "<IfThenElse><AlwaysSuccess/></IfThenElse>",
            "<AlwaysSuccess><AlwaysSuccess/></AlwaysSuccess>",
            "<RunOnce then_skip='yes'><AlwaysSuccess/></RunOnce>",
        ],
    )
    def test_the_own_schema_refuses_mistakes(self, schema, body):
        text = f'<root><BehaviorTree ID="A">{body}</BehaviorTree></root>'

        assert not schema.validate(etree.fromstring(text))

    def test_the_engines_schema_takes_every_built_in_node(self, engine_facts):
        schema = etree.XMLSchema(etree.parse(engine_facts / "groot2" / "schema.xsd"))
        tree = SubTree("x", AlwaysSuccess(post="b := 1"), remap={"a": "{b}"}, autoremap=True)
        schema.assertValid(etree.fromstring(tree_to_xml(tree, REGISTRY).encode()))
        registry = BehaviourRegistry()
        for name in registry.names():
            if name == "SubTree":
                continue
            cls = registry.get(name)
            values = {
                port.name: "{x}" for port in cls.ports.values() if port.mandatory or port.writes
            }
            given = {port.attribute: values[port.name] for port in cls.ports.values()
                     if port.name in values}  # fmt: skip
            count = {"Control": getattr(cls, "least_children", 0), "Decorator": 1}.get(cls.kind, 0)
            node = cls(*[AlwaysSuccess() for _ in range(count)], **given)
            schema.assertValid(etree.fromstring(tree_to_xml(node, registry).encode()))

    def test_the_model_says_all_about_a_behaviour(self):
        root = models_document(REGISTRY)
        text = write_source(Source(root))

        assert '<Action ID="Hover">' in text and "Sequence" not in text
        assert '<input_port name="height" type="double" default="0.4">' in text
        assert "<description>Move the tool over an object.</description>" in text

    def test_the_model_of_the_built_in_nodes_is_the_engines(self, engine_facts):
        text = write_source(Source(models_document(BehaviourRegistry(), built_in=True)))
        ours = models_of(etree.fromstring(text.encode()))
        theirs = models_of(etree.parse(engine_facts / "groot2" / "tree_nodes_model_all.xml"))

        assert ours == {name: theirs[name] for name in ours}
        assert len(ours) == len(BehaviourRegistry().names()) - 1
