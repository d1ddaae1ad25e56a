"""Which cluster is which object: by look, by place for those that look alike, or refused."""

from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip.cell import as_object
from bt_manip.cell.objects import Box, Can, Cylinder
from bt_manip.spatial import pose
from bt_manip_camera.beliefs import edges
from bt_manip_camera.estimation import KnownObject, name_clusters
from bt_manip_camera.perception import Perception, known_object
from bt_manip_camera.segmentation import Cluster

RED, YELLOW, BLUE = (0.78, 0.2, 0.18), (0.92, 0.76, 0.22), (0.2, 0.4, 0.72)


def block(name, colour=RED):
    return KnownObject(name, "box", (0.04, 0.04, 0.04), colour)


def cluster(x, y=0.0, colour=RED):
    side = np.linspace(-0.02, 0.02, 41)
    top = np.stack(np.meshgrid(x + side, y + side), axis=-1).reshape(-1, 2)
    return Cluster(top, 0.04, 1.0, np.array(colour), 1e-3)


def named(places, names, believed=None, gone=()):
    """Give the x of each named object, and the reasons of refusals."""
    believed = {name: np.array([x, 0.0]) for name, x in (believed or {}).items()}
    clusters, objects = [cluster(x) for x in sorted(places)], [block(name) for name in names]
    found, refused = name_clusters(clusters, objects, believed, gone)
    return {name: round(float(one.middle[0]), 3) for name, one in found.items()}, refused


NAMED = {
    "all are seen: numbered by position": (
        ([0.4, 0.2, 0.3], "abc"), {"a": 0.2, "b": 0.3, "c": 0.4}
    ),
    "each is where it was seen": (
        ([0.2, 0.3, 0.4], "abc", {"a": 0.41, "b": 0.2, "c": 0.3}), {"a": 0.4, "b": 0.2, "c": 0.3}
    ),
    "one has moved, the others are where they were": (
        ([0.2, 0.3, 0.5], "abc", {"a": 0.2, "b": 0.3, "c": 0.4}, {"c"}),
        {"a": 0.2, "b": 0.3, "c": 0.5},
    ),
    "one is out of sight": (([0.2], "ab", {"a": 0.2, "b": 0.9}), {"a": 0.2}),
    "its place is seen to be empty": (([0.4], "a", {"a": 0.2}, {"a"}), {"a": 0.4}),
    "nothing else has room at its place": (([0.235], "a", {"a": 0.2}), {"a": 0.235}),
    "gone, and nowhere else": (([], "ab", {"a": 0.2, "b": 0.3}, "ab"), {}),
}  # fmt: skip


@pytest.mark.parametrize("case", NAMED)
def test_objects_that_look_alike_are_told_apart_by_their_places(case):
    arguments, expected = NAMED[case]
    assert named(*arguments) == (expected, {})


# Farther away than a block is wide, or half as wide where others look alike, it may be another.
@pytest.mark.parametrize(
    ("names", "away", "known"),
    [("a", 0.045, False), ("a", 0.035, True), ("ab", 0.025, False), ("ab", 0.015, True)],
)
def test_an_oblong_object_is_known_by_its_place_within_its_shorter_side(names, away, known):
    side = np.linspace(-0.03, 0.03, 61)
    top = np.stack(np.meshgrid(0.2 + side[10:51], side), axis=-1).reshape(-1, 2)
    seen = Cluster(top, 0.04, 1.0, np.array(RED), 1e-3)
    believed = {"a": np.array([0.2 + away, 0.0])} | {
        name: np.array([0.9, 0.0]) for name in names[1:]
    }
    objects = [KnownObject(name, "box", (0.04, 0.06, 0.04)) for name in names]
    found, refused = name_clusters([seen], objects, believed)
    assert ("a" in found) == known and bool(refused) != known


@pytest.mark.parametrize(
    ("arguments", "name", "reason"),
    [
        (([0.2, 0.3], "abc"), "b", "'a' and 'b' and 'c' look like the same thing"),
        (([0.2, 0.35, 0.5], "abc", {"a": 0.2, "b": 0.27, "c": 0.4}, {"b", "c"}), "b",
         "'b' and 'c' look alike, and may have been exchanged"),
        (([0.4], "a", {"a": 0.2}), "a", "'a' may be what looks the same elsewhere"),
        (([0.2], "ab", {"a": 0.195, "b": 0.205}), "b", "'a' and 'b' may be what looks the same"),
        (([0.2, 0.4], "a", {"a": 0.2}), "a", "2 things look like 'a'"),
    ],
)  # fmt: skip
def test_objects_that_look_alike_are_refused_where_they_may_be_exchanged(arguments, name, reason):
    found, refused = named(*arguments)
    assert found == {}
    assert reason in refused[name]


def test_the_nearest_colour_decides_and_nothing_where_two_are_as_near():
    objects = [block("red"), block("yellow", YELLOW), block("blue", BLUE)]
    clusters = [cluster(0.2, colour=YELLOW), cluster(0.3), cluster(0.4, colour=BLUE)]
    found, refused = name_clusters(clusters, objects)
    assert refused == {}
    assert {name: round(float(one.middle[0]), 2) for name, one in found.items()} == {
        "yellow": 0.2, "red": 0.3, "blue": 0.4
    }  # fmt: skip
    for angle, clear in ((12.0, False), (14.0, True)):  # 7 and 9 degrees more than the other
        near, far = ((np.cos(a), np.sin(a), 0.0) for a in np.radians((5.0, angle)))
        seen = cluster(0.2, colour=(1.0, 0.0, 0.0))
        found, refused = name_clusters([seen], [block("near", near), block("far", far)])
        assert ("near" in found) == clear and "far" not in found and bool(refused) != clear
    between = tuple((np.array(RED) / np.linalg.norm(RED) + YELLOW / np.linalg.norm(YELLOW)) / 2)
    found, refused = name_clusters([cluster(0.2, colour=between)], [*objects, block("ruby")])
    assert found == {} and {*refused} == {"red", "yellow", "ruby"}
    for reason in refused.values():  # the first name of those that look alike
        assert reason.startswith("'red' and 'yellow' look like the same thing")


def test_objects_are_where_they_stand_whatever_their_origins_are(parts, see):
    cell, camera = see()
    cell.remove("cube")
    top, given = cell.surface_height("table"), {}
    for x, model, parameters in (
        (0.15, "box", {"size": (0.06, 0.04, 0.09)}), (0.3, "can", {}),
        (0.45, "coloured_block", {"colour": "green"}),
    ):  # fmt: skip
        thing = parts.objects.create(model, **parameters)
        height = top + as_object(thing).rest_height
        given[model] = pose((x, 0.05, height), (np.cos(0.1), 0, 0, np.sin(0.1)))
        cell.add(thing, given[model], name=model)
    frame = camera.expose(np.random.default_rng(0))
    seen = Perception(cell, None, {}, parts.objects).see(frame, top, [*given])
    assert not seen.missing
    for name, T_wo in given.items():
        np.testing.assert_allclose(seen.found[name].T_wo.translation, T_wo.translation, atol=3e-3)


def test_what_is_known_of_a_thing_is_its_whole_size_which_it_is_outlined_by():
    sides = 0.06, 0.04, 0.05
    found = known_object("box", box := Box(size=sides, colour=(0.1, 0.2, 0.9)))
    assert (*found.size, *found.colour) == pytest.approx((*sides, 0.1, 0.2, 0.9))
    for rgba, material in ((None, None), ((1, 1, 1, 0.5), None), ((1, 1, 1, 1), "wood")):
        geom = SimpleNamespace(type="box", size=sides, rgba=rgba, material=material)
        assert known_object("box", SimpleNamespace(collision_geoms=[geom])).colour is None
    ends = edges("box", SimpleNamespace(entities={"box": box}))
    off = np.sort(np.abs(ends[:, 1] - ends[:, 0]), axis=0)
    np.testing.assert_allclose(off, np.outer(np.arange(12) > 7, sides), atol=1e-9)
    assert np.abs(ends).max(axis=(0, 1)) == pytest.approx(np.divide(sides, 2))
    ends = edges("can", SimpleNamespace(entities={"can": Can(radius=0.03, height=0.1)}))
    assert ends.reshape(-1, 3).min(axis=0) == pytest.approx([-0.03, -0.03, 0.0])  # of its bottom
    assert ends.reshape(-1, 3).max(axis=0) == pytest.approx([0.03, 0.03, 0.1])
    found = known_object("can", Cylinder(radius=0.03, height=0.1))
    assert found.shape == "cylinder" and found.size == pytest.approx((0.06, 0.06, 0.1))
