"""Everything that says what a run shall do."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from bt_manip.exceptions import BtManipError
from bt_manip.runner.tree_source import TreeSource

CONTROLLER = "computed_torque"
"""Name of the controller of a run that asks for none."""

SCENE = "table_and_basket"
"""Name of the scene of a run that asks for none."""

PLANNER = "rrt_connect"
"""Name of the planner of a run that asks for none."""

CONTROL_STEP = 0.001
"""Time between two control steps [s]."""


@dataclass(frozen=True)
class RunRequest:
    """What to run, with what, how often.

    The same request gives the same run, bit for bit; who watches a run is no part of it.

    Attributes:
        tree: The tree to run.
        robot: Name of a registered robot, or path of a TOML file that describes one.
        controller: Name of a registered controller.
        scene: Name of a registered scene, or path of a TOML file that describes one.
        planner: Name of a registered planner.
        cycles: Runs of the root from idle to SUCCESS or FAILURE; 0 goes on until it is stopped.
        seed: Seed of all randomness.
        tick: Simulated time between two ticks of the tree [s], a whole number of control steps.
        settings: Values for keys that the tree declares at its root, as text.
        real_time: Simulated seconds per second of wall time to slow down to; None runs free.
    """

    tree: TreeSource
    robot: str = "panda"
    controller: str = CONTROLLER
    scene: str = SCENE
    planner: str = PLANNER
    cycles: int = 1
    seed: int = 0
    tick: float = 0.010
    settings: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    real_time: float | None = None

    def __post_init__(self) -> None:
        """Refuse numbers that no run can have.

        Raises:
            BtManipError: When a number is outside what it may be.
        """
        if self.cycles < 0:
            raise BtManipError(
                f"cycles must be 0 (until interrupted) or a positive number, got {self.cycles}"
            )
        if self.seed < 0:
            raise BtManipError(f"seed must be 0 or a positive number, got {self.seed}")
        if not 0.0 < self.tick < 60.0:
            raise BtManipError(f"tick must be positive and below 60 s, got {self.tick:g} s")
        if abs(self.tick / CONTROL_STEP - self.steps_per_tick) > 1e-6 or self.steps_per_tick < 1:
            raise BtManipError(
                f"tick must be a whole number of control steps of {CONTROL_STEP * 1e3:g} ms, "
                f"got {self.tick * 1e3:g} ms"
            )
        if self.real_time is not None and not 0.0 < self.real_time < float("inf"):
            raise BtManipError(f"real-time factor must be positive, got {self.real_time:g}")

    @property
    def steps_per_tick(self) -> int:
        """How many control steps there are in one tick."""
        return round(self.tick / CONTROL_STEP)
