"""The cell: an arena whose entities come and go while the physics runs."""

import contextlib
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import composer, mjcf

from bt_manip.cell.arena import Arena
from bt_manip.cell.compiled import Compiled, Placement
from bt_manip.cell.contacts import Contacts
from bt_manip.cell.exceptions import CellError
from bt_manip.cell.naming import name_elements, unique_name
from bt_manip.cell.state import carry_state, integration_state, set_integration_state
from bt_manip.cell.touch import TouchMonitor
from bt_manip.exceptions import did_you_mean
from bt_manip.spatial import pose as make_pose
from bt_manip.spatial import quat_wxyz

Factory = Callable[[Mapping[str, Any]], composer.Entity]


class Cell:
    """Owns the arena and its compiled physics, and is the one loop that steps it.

    Entities live by composer's hooks: ``after_compile`` runs for all of them after every change,
    ``initialize_episode`` once for each that is new, ``before_substep`` and ``after_substep``
    around each step, in the order in which ``composer.Environment`` runs them.
    """

    def __init__(
        self,
        arena: composer.Arena | None = None,
        timestep: float = 1e-3,
        random_state: np.random.RandomState | None = None,
    ):
        """Make a cell with nothing in it, or with what the arena already holds.

        Args:
            arena: The room; default: the project's own.
            timestep: Step of the physics [s].
            random_state: What composer's hooks get to draw from; default: seed 0.
        """
        self.arena = arena if arena is not None else Arena(timestep=timestep)
        self.arena.mjcf_model.option.timestep = timestep
        self.random_state = random_state or np.random.RandomState(0)
        self.generation = 0
        """Counts the compiles; whoever keeps views of the data looks here whether they are old."""
        self._placed: dict[str, Placement] = {}
        self._fresh: list[composer.Entity] = list(self.arena.iter_entities())
        self._editing = False
        self._now: Compiled | None = None
        self._compile()

    # What is in it

    @property
    def entities(self) -> Mapping[str, composer.Entity]:
        """Everything that was added, robots too, by name, in order."""
        return MappingProxyType({name: p.entity for name, p in self._placed.items()})

    @property
    def objects(self) -> Mapping[str, composer.Entity]:
        """The things to work with or around: entities with a ``category``, and free ones."""
        things = self._placed.items()
        return MappingProxyType(
            {n: p.entity for n, p in things if p.free or hasattr(p.entity, "category")}
        )

    def find(self, name: str) -> composer.Entity:
        """Give the entity of a name.

        Raises:
            CellError: When there is none; the nearest names are offered.
        """
        return self._placement(name).entity

    def add(
        self,
        entity: composer.Entity,
        pose: pin.SE3 | None = None,
        *,
        name: str | None = None,
        free: bool | None = None,
    ) -> str:
        """Put an entity into the cell while everything else keeps its exact state.

        Args:
            entity: A composer entity that stands nowhere else.
            pose: Pose of its root in the world; default: the origin.
            name: Name to give it, with ``_1``, ``_2``, ... where taken; default: its model's name.
            free: Whether it moves freely; default: the entity's own ``free``, or fixed.

        Returns:
            The name it got.

        Raises:
            CellError: When the model does not compile; the cell is unchanged.
        """
        model_name = entity.mjcf_model.model
        if entity.parent is not None:
            raise CellError(f"'{model_name}' already stands in a cell or on an entity")
        label = unique_name(name or model_name, self._placed)
        if "/" in label:
            raise CellError(f"a name cannot contain '/', got '{label}'")
        if free is None:
            free = bool(getattr(entity, "free", False))
        T_we = pose if pose is not None else pin.SE3.Identity()
        placement = Placement(
            entity, tuple(T_we.translation.tolist()), tuple(quat_wxyz(T_we).tolist()), free
        )
        try:
            with self._change(f"'{label}' cannot be added"):
                self._attach(label, placement)
                self._fresh.extend(entity.iter_entities())
        except CellError:
            entity.mjcf_model.model = model_name
            raise
        return label

    def remove(self, name: str) -> composer.Entity:
        """Take an entity out while everything else keeps its exact state.

        Returns:
            The entity, which can be added again.

        Raises:
            CellError: When there is none of that name; the cell is unchanged.
        """
        entity = self.find(name)
        with self._change(f"'{name}' cannot be removed"):
            self._detach(name)
        return entity

    @contextlib.contextmanager
    def editing(self) -> Iterator[None]:
        """Compile once for all that is added and removed inside, or leave the cell as it was.

        Inside, the physics is still the old one.

        Raises:
            CellError: When the changed cell does not compile.
        """
        with self._change("the cell cannot be changed"):
            self._editing = True
            try:
                yield
            finally:
                self._editing = False

    # How it moves

    def step(self, n: int = 1) -> None:
        """Make ``n`` control steps: the entities' hooks around each step of the physics.

        Raises:
            PhysicsDiverged: When MuJoCo warns, as it does of numbers that are not finite.
        """
        self._compiled.step(n, self.random_state)

    @property
    def physics(self) -> mjcf.Physics:
        """The compiled physics; a change of the cell makes a new one."""
        return self._compiled.physics

    @property
    def model(self) -> mujoco.MjModel:
        """MuJoCo's own model."""
        return self._compiled.model

    @property
    def data(self) -> mujoco.MjData:
        """MuJoCo's own data."""
        return self._compiled.data

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._compiled.data.time

    @property
    def dt(self) -> float:
        """Duration of a step [s]."""
        return self._compiled.model.opt.timestep

    # Where things are, and what touches what

    def pose(self, name: str) -> pin.SE3:
        """Give the pose of an entity's root in the world, ``T_we``.

        Raises:
            CellError: When there is none of that name.
        """
        placement = self._placement(name)
        if not placement.free or name not in self._compiled.free_joints:
            return placement.pose
        qpos, _ = self._compiled.free_joints[name]
        q = self.data.qpos[qpos : qpos + 7]
        return make_pose(q[:3], q[3:])

    def velocity(self, name: str) -> np.ndarray:
        """Give the velocity of an entity's root: linear, then angular, both in the world.

        Raises:
            CellError: When there is none of that name.
        """  # (6,) [m/s, rad/s]
        if not self._placement(name).free or name not in self._compiled.free_joints:
            return np.zeros(6)
        _, dof = self._compiled.free_joints[name]
        v = self.data.qvel[dof : dof + 6].copy()
        v[3:] = self.pose(name).rotation @ v[3:]  # a free joint's angular part is local
        return v

    def body_id(self, name: str) -> int:
        """Give the id of the root body of an entity, or of a body called ``entity/body``.

        Raises:
            CellError: When nothing is called so.
        """
        labels = self._compiled.labels
        try:
            return labels.body_ids(name)[0]
        except KeyError:
            raise CellError(
                f"no body or entity is called '{name}'{did_you_mean(name, labels.names())}"
            ) from None

    @property
    def contacts(self) -> Contacts:
        """The contacts of the last step."""
        return self._compiled.contacts

    @property
    def touch(self) -> TouchMonitor:
        """The judge of each step's contacts."""
        return self._compiled.touch

    # Its state

    def state_bytes(self) -> bytes:
        """Give MuJoCo's integration state as bytes, for digests and comparisons."""
        return integration_state(self.model, self.data).tobytes()

    def get_state(self) -> dict[str, Any]:
        """Give the integration state and what stands in the cell, as plain data."""
        return {
            "entities": [_describe(name, p) for name, p in self._placed.items()],
            "integration": integration_state(self.model, self.data).tolist(),
        }

    def set_state(self, state: Mapping[str, Any], factory: Factory | None = None) -> None:
        """Put a state back, taking out and putting in entities where that is needed.

        What already stands at its place in the order, alike in name and kind, stays what it is.

        Args:
            state: What ``get_state`` gave.
            factory: Makes the entity of an entry of ``state["entities"]``; needed where the cell
                lacks one.

        Raises:
            CellError: When an entity is missing and cannot be made, or the numbers do not fit;
                the cell is unchanged but for entities that came and went.
        """
        entries = state["entities"]
        present = list(self._placed.items())
        keep = 0
        while keep < min(len(entries), len(present)) and _describe(*present[keep]) == entries[keep]:
            keep += 1
        if keep < max(len(entries), len(present)):
            with self.editing():
                spare = dict(present[keep:])
                for name in spare:
                    self._detach(name)
                for entry in entries[keep:]:
                    self._attach(entry["name"], self._restored(entry, spare, factory))
        try:
            set_integration_state(self.model, self.data, np.array(state["integration"]))
        except ValueError as error:
            raise CellError(f"the state does not fit this cell: {error}") from error

    def _restored(
        self, entry: Mapping[str, Any], spare: dict[str, Placement], factory: Factory | None
    ) -> Placement:
        """Find or make the entity of an entry of a state."""
        name = entry["name"]
        if name in spare and _describe(name, spare[name]) == entry:
            return spare.pop(name)
        if factory is None:
            raise CellError(f"the state has a '{name}' that this cell lacks, and no way to make it")
        entity = factory(entry)
        self._fresh.extend(entity.iter_entities())
        return Placement(entity, tuple(entry["position"]), tuple(entry["quat_wxyz"]), entry["free"])

    # Inside

    @property
    def _compiled(self) -> Compiled:
        assert self._now is not None
        return self._now

    def _placement(self, name: str) -> Placement:
        try:
            return self._placed[name]
        except KeyError:
            near = did_you_mean(name, self._placed)
            raise CellError(f"there is no '{name}' in the cell{near}") from None

    def _attach(self, name: str, placement: Placement) -> None:
        entity = placement.entity
        entity.mjcf_model.model = name
        for part in entity.iter_entities():
            name_elements(part.mjcf_model)
        attach = self.arena.add_free_entity if placement.free else self.arena.attach
        frame = attach(entity)
        self._placed[name] = placement
        frame.pos = placement.position
        frame.quat = placement.quat_wxyz

    def _detach(self, name: str) -> None:
        self._placed.pop(name).entity.detach()

    @contextlib.contextmanager
    def _change(self, failure: str) -> Iterator[None]:
        """Compile after a change of the arena, or undo the change."""
        if self._editing:  # whoever edits compiles, and undoes
            yield
            return
        before = dict(self._placed)
        try:
            yield
            self._compile()
        except BaseException as error:
            for name, placement in list(self._placed.items()):
                if before.get(name) is not placement:
                    self._detach(name)
            for name, placement in before.items():
                if name not in self._placed:
                    self._attach(name, placement)
            self._placed = {name: self._placed[name] for name in before}
            if isinstance(error, CellError) or not isinstance(error, Exception):
                raise
            raise CellError(f"{failure}: {_first_line(error)}") from error
        finally:
            self._fresh.clear()

    def _compile(self) -> None:
        """Compile the arena and carry the state over; only then the old physics goes."""
        old, new = self._now, Compiled(self.arena, self._placed)
        entities = list(self.arena.iter_entities())
        try:
            if old is not None:
                carry_state(old.model, old.data, new.model, new.data)
                mujoco.mj_forward(new.model, new.data)
            for entity in entities:
                entity.after_compile(new.physics, self.random_state)
            for entity in self._fresh:
                entity.initialize_episode(new.physics, self.random_state)
            mujoco.mj_forward(new.model, new.data)
        except BaseException:
            if old is not None:
                for entity in entities:  # those that stay look at the old physics again
                    if entity not in self._fresh:
                        entity.after_compile(old.physics, self.random_state)
            raise
        self._now = new
        self.generation += 1
        if old is not None:
            old.physics.free()


def _describe(name: str, placement: Placement) -> dict[str, Any]:
    """Say as plain data what it takes to place an entity again."""
    return {
        "name": name,
        "kind": getattr(placement.entity, "kind", None),
        "parameters": dict(getattr(placement.entity, "parameters", {})),
        "free": placement.free,
        "position": list(placement.position),
        "quat_wxyz": list(placement.quat_wxyz),
    }


def _first_line(error: BaseException) -> str:
    """Give the line that says most: MuJoCo's own, which PyMJCF wraps."""
    while error.__cause__ or error.__context__:
        error = error.__cause__ or error.__context__ or error
    return (str(error).strip() or type(error).__name__).splitlines()[0]
