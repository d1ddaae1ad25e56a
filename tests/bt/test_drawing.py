"""Trees as text, DOT and SVG."""

import py_trees
import pytest
from lxml import etree

from bt_manip.behaviours import Hover
from bt_manip.bt import (
    AlwaysFailure,
    AlwaysSuccess,
    Fallback,
    Inverter,
    Sequence,
    Sleep,
    SubTree,
    Tree,
    draw_dot,
    draw_svg,
    draw_text,
)


@pytest.fixture
def tree():
    return Tree(
        Sequence(
            "pick",
            [
                Hover(object="{cube}", skip_if="x < 3"),
                SubTree("sub", Fallback(Inverter("not", AlwaysSuccess())), cube="{object}"),
                py_trees.composites.Sequence("stock", True, [AlwaysSuccess("ours")]),
            ],
        )
    )


def test_a_tree_as_text(tree):
    assert draw_text(tree) == (
        "pick\n"
        '└─ → Sequence "pick"\n'
        "   ├─ Hover  object={cube} _skipIf=x < 3\n"
        '   ├─ SubTree sub "sub"  cube={object}\n'
        "   │  └─ ? Fallback\n"
        '   │     └─ Inverter "not"\n'
        "   │        └─ AlwaysSuccess\n"
        '   └─ → Sequence "stock"\n'
        '      └─ AlwaysSuccess "ours"\n'
    )


def test_a_tree_as_dot(tree):
    text = draw_dot(tree)
    assert text.startswith('digraph "pick" {') and text.endswith("}\n")
    assert text.count("->") == len(tree.nodes) - 1
    assert 'label="Hover\\nobject={cube}\\n_skipIf=x < 3"' in text


def lines_of(text):
    """Return the picture and the text of each of its lines."""
    picture = etree.fromstring(text.encode())
    lines = (line.itertext() for line in picture.iterfind(".//{*}text"))
    return picture, [" ".join(" ".join(words).split()) for words in lines]


def test_a_tree_as_svg(tree):
    _, lines = lines_of(draw_svg(tree))
    written = draw_text(tree).splitlines()[1:]
    assert lines == [" ".join(line.strip("│├└─ ").split()) for line in written]


def test_a_picture_has_a_line_for_each_node_with_its_status_and_reason():
    tree = Tree(Fallback("try", AlwaysFailure("not today"), Sleep("<rest>", msec=5)))
    tree.tick()
    _, lines = lines_of(draw_svg(tree, ports=False))
    assert lines == [
        '? Fallback "try" RUNNING',
        'AlwaysFailure "not today" FAILURE always fails',
        'Sleep "<rest>" RUNNING',
    ]
    assert tree._repr_svg_() == draw_svg(tree, ports=False)


def test_a_line_of_a_picture_is_below_and_right_of_that_of_its_parent(tree):
    picture, _ = lines_of(draw_svg(tree))
    places = [(float(r.get("x")), float(r.get("y"))) for r in picture.iterfind(".//{*}rect")]
    assert len(places) == len(tree.nodes)
    assert [y for _, y in places] == sorted(y for _, y in places)
    root, *others = places
    assert all(x > root[0] for x, _ in others)
    assert all(x < float(picture.get("width")) for x, _ in places)
