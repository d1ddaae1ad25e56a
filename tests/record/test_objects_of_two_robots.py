"""What two robots gripped, and where it ended: the report against MuJoCo's own state."""

from collections import Counter

import mujoco
import numpy as np
import pytest

from bt_manip import build_station, spatial
from bt_manip.behaviours import (
    Drop,
    Grasp,
    Hover,
    IsIn,
    Lift,
    MoveHome,
    OpenGripper,
    PlaceAt,
    Reach,
    RemoveObject,
    SpawnObject,
)
from bt_manip.bt import Sequence, Sleep, Tree
from bt_manip.cell.objects import Cube, RedBlock
from bt_manip.record.report.recorder import Recorder
from bt_manip.runner import Run, RunObserver, RunRequest, TreeSource
from bt_manip.scenes import two_arms

TABLE = 1.015  # [m] height
REGIONS = {"left": (-0.25, -0.1, -0.3, -0.1), "right": (0.1, 0.25, 0.1, 0.3)}  # in reach [m]
GAP = 0.12  # [m] between the centres of objects
GRIPPED = 5.0  # [N] on both fingers
SLOW = 5e-3  # [m/s]


class Oracle(RunObserver):
    """Computes from contacts, positions and velocities what was gripped and where it ended."""

    def __init__(self, names):
        self.names = names
        self.found: list[list] = []  # name, robot, whether it lies in a basket

    def run_started(self, run):
        self.run, self.cell = run, run.station.cell
        self.cell.before_remove.append(self.removed)

    def after_compile(self):
        model = self.cell.model
        self.body = [model.body(b).name for b in range(model.nbody)]
        self.of_geom = [self.body[b] for b in model.geom_bodyid]

    def contacts(self):
        for i, (a, b) in enumerate(self.cell.data.contact.geom.tolist()):
            force = np.zeros(6)
            mujoco.mj_contactForce(self.cell.model, self.cell.data, i, force)
            yield self.of_geom[a], self.of_geom[b], force[0]
            yield self.of_geom[b], self.of_geom[a], force[0]

    def after_step(self):
        force = Counter()
        for body, other, normal in self.contacts():
            name, (robot, _, finger) = body.partition("/")[0], other.partition("/")
            if name in self.names and "finger" in finger:
                force[name, robot, finger] += normal
        for name, robot in {key[:2] for key in force}:
            fingers = [f for key, f in force.items() if key[:2] == (name, robot)]
            known = any(one[0] == name and one[2] is None for one in self.found)
            if len(fingers) == 2 and min(fingers) > GRIPPED and not known:
                self.found.append([name, robot, None])

    def removed(self, name):
        for one in self.found:
            if one[0] == name and one[2] is None:
                one[2] = self.in_a_basket(name)

    def cycle_ended(self, status, reason):
        for name in self.names:
            self.removed(name)
        self.cell.before_remove.remove(self.removed)

    def in_a_basket(self, name):
        model, data = self.cell.model, self.cell.data
        body = model.body(f"{name}/").id
        dof = model.jnt_dofadr[model.body_jntadr[body]]
        touched = {b.partition("/")[0] for a, b, _ in self.contacts() if a.startswith(f"{name}/")}
        if np.linalg.norm(data.qvel[dof : dof + 3]) > SLOW:
            return False
        return any(
            self.over(body, basket) and touched <= {basket, *self.names}
            for basket in ("left_basket", "right_basket")
        )

    def over(self, body, basket):
        """Whether the body's centre is between the walls and below the rim."""
        model, data = self.cell.model, self.cell.data
        walls = [g for g, name in enumerate(self.of_geom) if name.startswith(f"{basket}/")]
        walls = [g for g in walls if model.geom_contype[g]]
        corners = [
            data.geom_xpos[g] + data.geom_xmat[g].reshape(3, 3) @ (model.geom_size[g] * signs)
            for g in walls
            for signs in np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).T.reshape(-1, 3)
        ]
        centre = data.subtree_com[body]
        return (centre > np.min(corners, axis=0)).all() and (centre < np.max(corners, axis=0)).all()


@pytest.fixture(scope="module")
def built():
    station = build_station(scene=two_arms())
    return station, station.get_state()


def arrange(station, rng):
    """Add three objects; return the tree and what it grips, with what is placed."""
    cell, taken, jobs, expected = station.cell, [], [], []
    names = [str(name) for name in rng.permutation(["a", "b", "c"])]
    with cell.editing():
        for name in names:
            robot = str(rng.choice(["left", "right"]))
            x0, x1, y0, y1 = REGIONS[robot]
            while True:
                at = rng.uniform((x0, y0), (x1, y1))
                if all(np.linalg.norm(at - other) > GAP for other in taken):
                    break
            taken.append(at)
            thing = Cube() if rng.random() < 0.5 else RedBlock()
            height = TABLE + thing.rest_height
            outcome = str(rng.choice(["basket", "table", "dropped", "held", "basket", "alone"]))
            if any(job[1:] == (robot, "held") for job in jobs):
                outcome = "alone"  # that robot's gripper is full
            T_wo = spatial.pose((*at, height))
            if outcome == "alone" and rng.random() < 0.5:  # it lies in a basket from the start
                T_wo = spatial.pose(cell.pose(f"{robot}_basket").translation + (0, 0, 0.12))
            cell.add(thing, T_wo, name=name)
            jobs.append((name, robot, outcome))
            if outcome != "alone":
                expected.append((name, robot, outcome == "basket"))
    cell.step(1000)
    steps = []
    for name, robot, outcome in jobs:
        if outcome == "alone":
            continue
        at = cell.pose(name).translation
        steps += [
            OpenGripper(robot=robot),
            Hover(object=name, height=0.25, robot=robot),
            Reach(object=name, robot=robot),
            Grasp(object=name, robot=robot),
            Lift(height=0.25, robot=robot),
        ]
        if outcome == "basket":
            steps.append(Drop(container=f"{robot}_basket", robot=robot))
        elif outcome == "table":
            place = f"{at[0]};{at[1]};{TABLE}"
            steps.append(PlaceAt(object=name, pose=place, robot=robot))
            steps.append(Lift(height=0.25, robot=robot))
        elif outcome == "dropped":
            steps += [OpenGripper(robot=robot), Sleep(msec=800)]
        if outcome != "held" and rng.random() < 0.4:
            steps.append(RemoveObject(object=name))
        steps.append(MoveHome(robot=robot))
    steps.append(SpawnObject(model="green_block", region="-0.05;0.05;-0.5;-0.4", object="{late}"))
    steps.append(Sleep(msec=300))
    goal = [IsIn(object=name, container=f"{robot}_basket") for name, robot, _ in expected]
    return Tree(Sequence("task", steps), clock=station.clock, goal=goal), names, expected


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.soak) for seed in range(1, 50))]
)
def test_the_report_names_what_was_gripped_and_where_it_ended(built, seed):
    station, start = built
    station.set_state(start)
    tree, names, expected = arrange(station, np.random.default_rng(seed))
    tree.setup(**station.infrastructure)
    recorder, oracle = Recorder("test", seed), Oracle(names)
    Run(RunRequest(TreeSource("test", "python")), tree, station).execute([recorder, oracle])
    (cycle,) = recorder.report().cycles
    assert all(phase.status == "SUCCESS" for phase in cycle.phases), cycle.reason
    assert (cycle.status == "SUCCESS") == all(one[2] for one in expected)
    objects = [(one.name, one.robot, one.placed) for one in cycle.objects]
    assert objects == [tuple(one) for one in oracle.found] == expected
    assert cycle.object == (expected[0][0] if len(expected) == 1 else None)
    assert cycle.placed == (all(one[2] for one in expected) if expected else None)
    for robot, figures in cycle.robots.items():
        assert figures.picked == tuple(one[0] for one in expected if one[1] == robot)
