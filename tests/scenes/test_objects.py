"""Objects of a scene: replaced by models of others, placed on supports, and drawn from a seed."""

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.cell import Cell, CellError, Cube, Region, Table, bottom_of
from bt_manip.scenes import (
    Scene,
    SceneObject,
    SceneRobot,
    add_object,
    check_supports,
    place_again,
    with_models,
)
from bt_manip.spatial import pose

TURN = (0.8, 0.0, 0.0, 0.6)
MODELS = {
    "table": SimpleNamespace(
        category="surface", surface_height=0.7, rest_height=0.1, centre_offset=(0.02, -0.01, 0.3)
    ),
    "other": SimpleNamespace(surface_height=1.0, rest_height=0.3, centre_offset=(0.05, 0.04, 0.5)),
}


@pytest.mark.parametrize(("base", "rise"), [(1.2009, 0.4991), (1.1991, 0.5009), (1.2011, 0.0)])
def test_another_model_has_its_bottom_where_it_was_and_lifts_what_is_at_a_base_or_above(base, rise):
    """The surface is at 1.2 m, and 1.7 m with the other model; 1 mm counts as the same height."""
    heights = [base, 0.2, 3.0], [0.5, base - 0.9e-3, base - 1.1e-3, 2.0, 0.4]
    robots = [SceneRobot(pose((0.1, i, z), TURN), f"r{i}") for i, z in enumerate(heights[0])]
    objects = [
        SceneObject("table", f"o{i}", pose((0.3, 0.2, z), TURN), on="o3" if i == 4 else "")
        for i, z in enumerate(heights[1])
    ]
    made = []
    catalogue = SimpleNamespace(
        create=lambda *given, **named: made.append(named) or MODELS[given[0]]
    )
    replaced = {"o0": "other", "o4": "other"}
    scene = with_models(Scene(tuple(robots), tuple(objects)), replaced, catalogue)
    for old, new, z in zip(robots, scene.robots, heights[0], strict=True):
        lift = pose((0.0, 0.0, rise if z > 1.0 else 0.0))
        assert new.T_wb.isApprox(lift * old.T_wb)
    bottoms = [bottom_of(MODELS[one.model]) for one in scene.objects]
    assert (scene.objects[0].T_wo * bottoms[0]).isApprox(
        objects[0].T_wo * bottom_of(MODELS["table"])
    )
    for i, lifted in enumerate((False, True, False, True, False)):
        if i:  # what is on another object keeps its height above it
            lift = pose((0.0, 0.0, rise if lifted else 0.0))
            assert scene.objects[i].T_wo.isApprox(lift * objects[i].T_wo)
    assert made == [{}, {"category": "surface"}] * 2


class Aside(Cube):
    """A cube whose bottom counts as beside its origin."""

    centre_offset = (0.1, 0.05, 0.0)


@pytest.fixture
def cell():
    cell = Cell()
    cell.add(Table())  # 1.5 x 0.8 m, 1.015 m high
    return cell


@pytest.mark.parametrize(
    ("x", "y", "beside"),
    [(0.2, 0.299, ""), (0.2, 0.301, "0.001 m beside it, at 0.150 0.401;"), (-0.699, 0.0, ""),
     (-0.702, 0.1, "0.002 m beside it, at -0.752 0.200;"), (0.2, -0.503, "0.003 m beside"),
     (0.804, 0.0, "0.004 m beside it, at 0.754 0.100; it extends from -0.750 to 0.750 along x")],
)  # fmt: skip
def test_an_object_may_overhang_its_support_up_to_the_middle_of_its_bottom(cell, x, y, beside):
    T_wo = pose((x, y, 0.02), (0.5**0.5, 0.0, 0.0, 0.5**0.5))
    added = SceneObject("cube", "it", T_wo, on="table")
    add_object(cell, added, Aside(), seed=0)
    assert cell.pose("it").isApprox(pose((0, 0, 1.015 + 0.025)) * T_wo)
    drawn = SceneObject(
        "cube", "it", T_wo, on="table", region=Region((x - 0.05, 9.0), (y + 0.1, 0.5), (0.0, 0.0))
    )
    for checked in (added, drawn) if 0.0 < x < 0.5 and y > 0.0 else (added,):
        if beside:
            with pytest.raises(CellError, match=f"'it' is not on 'table' but {beside}"):
                check_supports(cell, [checked])
        else:
            check_supports(cell, [checked])


def test_free_places_in_a_region_are_drawn_from_the_seed(cell):
    region, nowhere = Region((0.2, 0.34), (-0.07, 0.07), (0.0, 0.0)), pin.SE3.Identity()
    names = ("one", "two")
    objects = [SceneObject("cube", n, nowhere, on="table", region=region) for n in names]
    for one in objects:
        add_object(cell, one, Aside(), seed=0)

    def middles() -> np.ndarray:
        return np.array([(cell.pose(name) * bottom_of(Aside())).translation for name in names])

    found = [middles()]
    for seed in (0, 1):
        assert place_again(cell, objects, seed) == set(names)
        found.append(middles())
    assert (found[0] == found[1]).all() and (found[0] != found[2])[:, :2].all()
    for places in found:
        assert np.linalg.norm(places[0] - places[1]) > 0.05  # neither is inside the other
        assert (np.abs(places - [0.27, 0.0, 1.015]) <= [0.07, 0.07, 1e-9]).all()
