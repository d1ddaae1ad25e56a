"""Things that lie on the table as they fell are picked, whatever they are shaped like."""

import numpy as np
import pytest
import trimesh

from bt_manip import build_station, spatial
from bt_manip.behaviours import Grasp, Hover, IsHolding, Lift, Reach
from bt_manip.bt import Sequence
from bt_manip.cell import objects

PICKS = 20
# A mug that lies so that its handle is where a finger would be is not always picked.
REFUSED_AT_MOST = {"mug": 2}
TABLE = 1.015  # [m] height of its surface


def wedge_from_a_file(folder):
    """Make an object of an STL file: a prism whose sides are not parallel."""
    corners = np.array([[-0.03, -0.02], [0.03, -0.02], [0.02, 0.02], [-0.01, 0.03]])
    below = np.column_stack([corners, np.full(4, -0.02)])
    above = np.column_stack([0.8 * corners, np.full(4, 0.02)])
    path = folder / "wedge.stl"
    trimesh.convex.convex_hull(np.vstack([below, above])).export(path)
    return objects.ModelObject(str(path))


THINGS = {
    "box": lambda folder: objects.Box(),
    "rod": lambda folder: objects.Box(size=(0.18, 0.03, 0.02)),
    "plate": lambda folder: objects.Box(size=(0.09, 0.07, 0.008)),
    "cylinder": lambda folder: objects.Cylinder(),
    "sphere": lambda folder: objects.Sphere(),
    "capsule": lambda folder: objects.Capsule(),
    "can": lambda folder: objects.Can(),
    "bottle": lambda folder: objects.Bottle(),
    "mug": lambda folder: objects.Mug(),
    "mesh": lambda folder: objects.ConvexMesh(),
    "stl": wedge_from_a_file,
}


def drop_it(station, thing, rng):
    """Let a thing fall onto the table, turned anyhow, and wait until it lies still."""
    quat = rng.normal(size=4)
    place = (rng.uniform(0.3, 0.45), rng.uniform(-0.2, 0.2), TABLE + 0.25)
    station.cell.add(thing, spatial.pose(place, quat / np.linalg.norm(quat)), name="it")
    for _ in range(12):
        station.cell.step(250)
        if np.abs(station.cell.velocity("it")).max() < 0.01:
            return


@pytest.mark.soak
@pytest.mark.parametrize("name", THINGS)
def test_what_lies_on_the_table_as_it_fell_is_picked(name, tmp_path):
    empty_table = build_station()
    at_rest = empty_table.get_state()
    failed = {}
    for seed in range(PICKS):
        empty_table.set_state(at_rest)
        drop_it(empty_table, THINGS[name](tmp_path), np.random.default_rng(seed))
        z = empty_table.cell.pose("it").translation[2]
        grasp = Hover(object="it", height=0.3), Reach(object="it"), Grasp(object="it")
        pick = Sequence(*grasp, Lift(height=0.15), IsHolding(object="it"))
        reason = empty_table.run(pick).reason
        if reason or empty_table.cell.pose("it").translation[2] < z + 0.1:
            failed[seed] = reason or "it slipped"
    assert len(failed) <= REFUSED_AT_MOST.get(name, 0), failed
    assert all("leaves the gripper no clearance" in reason for reason in failed.values()), failed
