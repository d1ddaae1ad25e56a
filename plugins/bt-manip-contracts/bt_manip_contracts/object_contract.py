"""Contract of objects."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.cell import Cell, as_object

DROP_HEIGHT = 0.02  # [m]
MAX_SINKING = 1.5e-3  # [m]
MAX_DRIFT = 1e-3  # [m] in a second at rest
MAX_TILT = 0.02  # [rad]


@dataclass(frozen=True)
class ObjectCase:
    """A kind of object with parameters."""

    name: str
    factory: Callable[..., Any]
    parameters: Mapping[str, Any] = field(default_factory=dict)

    def make(self) -> Any:
        """Return a new object."""
        return self.factory(**self.parameters)

    def alone(self, height: float = 0.0) -> tuple[Cell, str]:
        """Return an empty cell with a new object on the floor, or above it."""
        cell, entity = Cell(), self.make()
        at = height + as_object(entity).rest_height
        return cell, cell.add(entity, spatial.pose((0.3, 0.2, at)))


def has_finite_inertia(case: ObjectCase) -> None:
    """Every moving body has a physically valid mass and inertia."""
    cell, name = case.alone()
    model = cell.model
    for body in range(1, model.nbody):
        label = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, body) or ""
        moves = model.body_weldid[body] != 0
        mass, inertia = float(model.body_mass[body]), model.body_inertia[body]
        assert np.isfinite(mass) and np.isfinite(inertia).all(), f"'{label}' is not finite"
        if label.startswith(name) and moves and model.body_jntnum[body]:
            subtree = float(model.body_subtreemass[body])
            assert subtree > 0.0, f"'{label}' moves and has no mass"
            a, b, c = sorted(inertia)
            assert mass == 0.0 or c <= (a + b) * (1 + 1e-9), (
                f"no solid has the inertia {inertia} of '{label}'"
            )


def is_stable_at_rest(case: ObjectCase) -> None:
    """At its rest height it neither sinks, drifts nor tips."""
    cell, name = case.alone()
    start = cell.pose(name)
    cell.step(500)
    settled = cell.pose(name)
    _near(start, settled, MAX_SINKING, f"'{case.name}' does not rest where it was put")
    cell.step(1000)
    _near(settled, cell.pose(name), MAX_DRIFT, f"'{case.name}' does not stay where it rests")
    speed = float(np.abs(cell.data.qvel).max(initial=0.0))
    assert speed < 0.01, f"'{case.name}' still moves after 1.5 s: {speed:.4f} m/s or rad/s"


def survives_a_fall(case: ObjectCase) -> None:
    """Dropped from 20 mm it comes to rest without penetrating the floor."""
    cell, name = case.alone(DROP_HEIGHT)
    rest = cell.pose(name).translation[2] - DROP_HEIGHT
    cell.step(2000)
    assert np.isfinite(cell.data.qpos).all()
    if name in cell.objects and as_object(cell.find(name)).free:
        sunk = rest - cell.pose(name).translation[2]
        assert sunk < MAX_SINKING, f"'{case.name}' is {1000 * sunk:.1f} mm inside the floor"


def is_made_again_from_its_parameters(case: ObjectCase) -> None:
    """Its kind and parameters recreate the same model, as snapshots do."""
    entity = case.make()
    declared = as_object(entity)
    kind = declared.kind
    assert kind == case.name, (
        f"'{case.name}' calls its kind {kind!r}, which a snapshot would create"
    )
    parameters = json.loads(json.dumps(dict(declared.parameters)))
    again = case.factory(**parameters)
    assert again.mjcf_model.to_xml_string() == entity.mjcf_model.to_xml_string(), (
        f"'{case.name}' recreated from {parameters} is different"
    )


def comes_and_goes_without_a_trace(case: ObjectCase) -> None:
    """Adding and removing it does not change the state of anything else."""
    cell = Cell()
    other = cell.add(case.make(), spatial.pose((0.0, -0.5, 0.5)), name="other")
    cell.step(50)
    before = cell.state_bytes()
    pose = cell.pose(other)
    name = cell.add(case.make(), spatial.pose((0.0, 0.5, 0.5)))
    assert (cell.pose(other).homogeneous == pose.homogeneous).all()
    cell.remove(name)
    assert cell.state_bytes() == before, f"'{case.name}' changes the state of others"


OBJECT_CONTRACT: tuple[Callable[[ObjectCase], None], ...] = (
    has_finite_inertia,
    is_stable_at_rest,
    survives_a_fall,
    is_made_again_from_its_parameters,
    comes_and_goes_without_a_trace,
)
"""Checks of the contract; each raises an `AssertionError`."""


def _near(before: pin.SE3, after: pin.SE3, limit: float, complaint: str) -> None:
    moved = float(np.linalg.norm(after.translation - before.translation))
    tilt = float(np.linalg.norm(pin.log3(before.rotation.T @ after.rotation)))
    assert moved <= limit, f"{complaint}: it moved {1000 * moved:.2f} mm"
    assert tilt <= MAX_TILT, f"{complaint}: it turned {tilt:.3f} rad"
