"""Contract of faults."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from bt_manip.bt import Sleep, Tree
from bt_manip.parameters import parameters_of
from bt_manip.registry import Parts
from bt_manip.runner import Station
from bt_manip.testing import Check, Situations

from .faults.fault import Fault, FaultContext, FaultError

HOLDING = "holding a cube over the table"  # a built-in situation
STEPS = 20  # control steps between the start and the end of a fault


@dataclass(frozen=True)
class FaultCase:
    """A fault and the situations to check it in."""

    name: str
    cls: type[Fault]
    situations: Situations

    def run(self, seed: int = 0) -> Station | None:
        """Start and end the fault while a cube is held; None if it cannot happen there."""
        station = self.situations.reset(HOLDING)
        tree = Tree(Sleep("rest", msec=1000), clock=station.clock)
        fault = self.cls()
        try:
            fault.start(FaultContext(station, tree, tree.root, np.random.default_rng(seed)))
        except FaultError:
            return None
        station.cell.step(STEPS)
        fault.end()
        return station


def is_documented(case: FaultCase) -> None:
    """Check that the fault and its parameters have a description."""
    assert (case.cls.__doc__ or "").strip(), f"'{case.name}' has no docstring"
    for name, declared in parameters_of(case.cls).items():
        assert declared.meaning, f"'{case.name}' does not describe '{name}'"


def is_undone_at_its_end(case: FaultCase) -> None:
    """Check that it leaves no overrides, forces, obstacles, missing fixtures or wrong sensors."""
    before = set(case.situations.reset(HOLDING).cell.entities)
    station = case.run()
    if station is None:
        return
    cell = station.cell
    after, fixed = set(cell.entities), before - {"cube"}
    assert not cell.overrides, f"'{case.name}' leaves the overrides {cell.overrides}"
    assert not cell.data.xfrc_applied.any(), f"'{case.name}' leaves external forces"
    assert fixed <= after <= before, f"'{case.name}' leaves {after} of {before} in the cell"
    for robot in station.robots.values():
        true = cell.data.qpos[robot.robot.qpos_adr]
        assert (robot.robot.q == true).all(), f"'{case.name}' leaves wrong sensors"


def depends_on_its_seed_only(case: FaultCase) -> None:
    """Check that the same seed leads to the same state, bit for bit."""
    states = [station and station.cell.state_bytes() for station in (case.run(), case.run())]
    assert states[0] == states[1], f"'{case.name}' draws from another generator than 'rng'"


FAULT_CONTRACT: tuple[Callable[[FaultCase], None], ...] = (
    is_documented,
    is_undone_at_its_end,
    depends_on_its_seed_only,
)
"""Checks of the contract; each raises `AssertionError` if it fails."""


def fault_checks(
    parts: Parts, provides: Mapping[str, tuple[str, ...]], settings: Mapping[str, Any]
) -> Iterator[Check]:
    """Yield the checks of a plugin's faults; arguments as of the hook ``register_contracts``."""

    def run(check: Callable[[FaultCase], None], name: str, situations: Situations) -> None:
        check(FaultCase(name, parts.of("faults").get(name), situations))

    for name in provides.get("faults", ()):
        for check in FAULT_CONTRACT:
            yield Check(f"{name}: {check.__name__.replace('_', ' ')}", partial(run, check, name))
