"""Perturbations: bodies are pulled by damped springs with a limited force."""

import math
from collections.abc import Callable, Container, Mapping
from contextlib import suppress
from typing import Any

import mujoco
import numpy as np

from bt_manip.cell import Cell, entity_of
from bt_manip.exceptions import BtManipError

MAX_FORCE = 50.0
"""Default limit of the force on a pulled body [N]: ten times the weight of an object of 0.5 kg."""


class Perturbations:
    """The active perturbations of a cell, at most one per body, as in MuJoCo's viewer.

    A perturbation is plain data, documented at the event ``intervention`` of `RunEvent`. Robots
    cannot be pulled. Whatever begins, changes or ends is notified.
    """

    def __init__(
        self, cell: Cell, robots: Container[str], notify: Callable[[dict[str, Any]], None]
    ) -> None:
        self._cell, self._robots, self._notify = cell, robots, notify
        self._active: dict[str, dict[str, Any]] = {}  # data by body, with its effective mass [kg]
        self._bound: list[tuple[np.ndarray, mujoco.MjvPerturb, float]] = []
        self._generation: int | None = None

    @property
    def active(self) -> bool:
        """Whether `apply` has to be called before each control step."""
        return bool(self._active)

    def check(self, data: Mapping[str, Any]) -> None:
        """Raise a `BtManipError` for a perturbation that is impossible."""
        if data["target"] is None:
            return
        point, target, force = data["point"], data["target"], data["max_force"]
        finite = all(map(math.isfinite, (*point, *target, force)))
        if not (len(point) == len(target) == 3 and finite and force >= 0.0):
            got = f"{point}, {target}, {force}"
            raise BtManipError(f"a pull needs two points and a force, got {got}")
        self._body(data["body"])

    def set(self, data: Mapping[str, Any]) -> None:
        """Begin, move or end the perturbation of a body; no effect if the body was removed."""
        if data["target"] is None:
            self._let_go(data["body"])
            return
        begins = data["body"] not in self._active
        try:
            mass = self._mass(data) if begins else self._active[data["body"]]["mass"]
        except BtManipError:
            return
        numbers = {key: data[key] for key in ("body", "point", "target", "max_force")}
        self._active[data["body"]] = {**numbers, "mass": mass}
        self._generation = None
        self._notify({"kind": "perturbation", **numbers, "begins": begins})

    def apply(self) -> None:
        """Set the forces of all perturbations for the next control step."""
        model, data = self._cell.model, self._cell.data
        if self._generation != self._cell.generation:
            self._bind()
        for wrench, spring, max_force in self._bound:
            mujoco.mjv_applyPerturbForce(model, data, spring)
            force = math.sqrt(wrench[:3] @ wrench[:3])
            if force > max_force:
                wrench *= max_force / force

    def clear(self) -> None:
        """End all perturbations."""
        for body in list(self._active):
            self._let_go(body)

    def get_state(self) -> list[dict[str, Any]]:
        """Return the active perturbations as plain data."""
        return [dict(one) for one in self._active.values()]

    def set_state(self, state: list[dict[str, Any]]) -> None:
        """Restore a state of `get_state`."""
        self._active = {one["body"]: dict(one) for one in state}
        self._generation = None

    def _body(self, name: str) -> int:
        body = self._cell.body_id(name)
        if entity_of(name) in self._robots:
            raise BtManipError(f"'{name}' is part of a robot: only other bodies can be pulled")
        if self._cell.model.body_weldid[body] == 0:
            raise BtManipError(f"'{name}' cannot be pulled: it is fixed")
        return body

    def _let_go(self, body: str) -> None:
        if self._active.pop(body, None) is None:
            return
        self._generation = None
        with suppress(BtManipError):  # removed
            self._cell.data.xfrc_applied[self._body(body)] = 0.0
        self._notify({"kind": "perturbation", "body": body, "target": None, "begins": False})

    def _mass(self, data: Mapping[str, Any]) -> float:
        """Return the effective mass at a point [kg], as ``mjv_initPerturb`` computes it."""
        model, physics, body = self._cell.model, self._cell.data, self._body(data["body"])
        point = physics.xpos[body] + physics.xmat[body].reshape(3, 3) @ data["point"]
        jacobian, solved = np.zeros((2, 3, model.nv))
        mujoco.mj_jac(model, physics, jacobian, None, point, body)
        mujoco.mj_solveM(model, physics, solved, jacobian)
        return 3.0 / max(float(np.sum(jacobian * solved)), mujoco.mjMINVAL)

    def _bind(self) -> None:
        """Bind the perturbations to the present model; drop perturbations of removed bodies."""
        self._bound = []
        for active in list(self._active.values()):
            try:
                body = self._body(active["body"])
            except BtManipError:
                self._let_go(active["body"])
                continue
            spring = mujoco.MjvPerturb()
            spring.select, spring.active = body, int(mujoco.mjtPertBit.mjPERT_TRANSLATE)
            spring.localpos, spring.refselpos = active["point"], active["target"]
            spring.localmass = active["mass"]
            self._bound.append((self._cell.data.xfrc_applied[body], spring, active["max_force"]))
        self._generation = self._cell.generation
