"""How a cell's things differ from their models: kept as plain data, written to the physics."""

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from bt_manip.cell.exceptions import CellError
from bt_manip.cell.physics.model_properties import (
    CAMERA,
    ENTITY,
    LIGHT,
    QUANTITIES,
    ModelProperty,
    quantity,
)
from bt_manip.exceptions import did_you_mean

Values = Mapping[str, Any]
"""Values by quantity: a number or a list of numbers each."""

_OBJECT = {LIGHT: mujoco.mjtObj.mjOBJ_LIGHT, CAMERA: mujoco.mjtObj.mjOBJ_CAMERA}
_WRITTEN = (
    "body_mass", "body_inertia", "geom_friction", "geom_rgba", "geom_matid",
    "actuator_gainprm", "actuator_biasprm",
    "light_pos", "light_dir", "light_diffuse", "light_ambient", "light_specular",
    "cam_pos", "cam_quat", "cam_fovy",
)  # fmt: skip
# What MuJoCo derives from these (mj_setConst).
_DERIVED = (
    "body_subtreemass", "body_invweight0", "dof_invweight0", "dof_M0", "tendon_invweight0",
    "tendon_length0", "tendon_lengthspring", "actuator_length0", "actuator_acc0",
    "cam_pos0", "cam_poscom0", "cam_mat0", "light_pos0", "light_poscom0", "light_dir0",
)  # fmt: skip


class Overrides:
    """Values by thing and quantity, of those that differ from the models.

    A thing is an entity by its name, ``light:NAME`` or ``camera:NAME``.
    """

    def __init__(self) -> None:
        """Begin with nothing altered."""
        self._values: dict[str, dict[str, Any]] = {}

    def __bool__(self) -> bool:
        """Tell whether anything is altered."""
        return bool(self._values)

    def get_state(self) -> dict[str, dict[str, Any]]:
        """Give all values as plain data."""
        return {thing: dict(values) for thing, values in self._values.items()}

    def set_state(self, state: Mapping[str, Values]) -> None:
        """Take all values back."""
        self._values = {thing: dict(values) for thing, values in state.items()}

    def forget(self, thing: str) -> None:
        """Let a thing be as its model again."""
        self._values.pop(thing, None)

    def put(self, thing: str, values: Values, model: mujoco.MjModel) -> None:
        """Take in values; None makes a quantity what the model says again.

        Args:
            thing: What is altered.
            values: Values by quantity.
            model: As it was compiled.

        Raises:
            CellError: When there is no such thing or quantity, or a value is impossible; nothing
                has been taken in then.
        """
        kind, ids = _find(model, thing)
        mine = dict(self._values.get(thing, {}))
        for name, value in values.items():
            known = quantity(kind, name)
            try:
                nominal = known.read(model, ids)
            except CellError as error:
                raise CellError(f"the {name} of '{thing}' cannot be altered: {error}") from None
            if value is None:
                mine.pop(name, None)
            else:
                mine[name] = _checked(thing, name, known, nominal, value)
        if mine:
            self._values[thing] = mine
        else:
            self.forget(thing)

    def write(self, model: mujoco.MjModel, nominal: mujoco.MjModel) -> None:
        """Let a model differ in exactly these values from the one that was compiled.

        Args:
            model: Is changed.
            nominal: As it was compiled.
        """
        for field in (*_WRITTEN, *_DERIVED):
            getattr(model, field)[:] = getattr(nominal, field)
        for thing, values in self._values.items():
            kind, ids = _find(nominal, thing)
            for name, known in QUANTITIES[kind].items():
                if name in values:
                    known.write(model, nominal, ids, np.asarray(values[name]))
        if any("mass" in values for values in self._values.values()):
            mujoco.mj_setConst(model, mujoco.MjData(model))


def nominal_value(model: mujoco.MjModel, thing: str, name: str) -> Any:
    """Give what a model says of a quantity.

    Raises:
        CellError: When there is no such thing or quantity.
    """
    kind, ids = _find(model, thing)
    return quantity(kind, name).read(model, ids)


def kind_of(thing: str) -> tuple[str, str]:
    """Split what is altered into its kind and its name."""
    kind, colon, name = thing.partition(":")
    return (kind, name) if colon and kind in _OBJECT else (ENTITY, thing)


def _find(model: mujoco.MjModel, thing: str) -> tuple[str, np.ndarray]:
    """Give the kind of a thing, and the ids of what it is made of in the model."""
    kind, name = kind_of(thing)
    if kind == ENTITY:
        bodies = [i for i in range(1, model.nbody) if model.body(i).name.partition("/")[0] == name]
        if not bodies:
            raise CellError(f"there is no '{name}' in the cell that could be altered")
        return kind, np.array(bodies)
    count = model.nlight if kind == LIGHT else model.ncam
    names = [mujoco.mj_id2name(model, _OBJECT[kind], i) or "" for i in range(count)]
    # A camera that is an entity goes by the entity's name.
    short = [n.partition("/")[0] if n.endswith("/eye") else n for n in names]
    for known in (names, short):
        if name in known:
            return kind, np.array([known.index(name)])
    raise CellError(f"there is no {kind} '{name}' in the cell{did_you_mean(name, short)}")


def _checked(thing: str, name: str, known: ModelProperty, nominal: Any, value: Any) -> Any:
    """Give a value as plain data, or refuse it."""
    wrong = CellError(f"the {name} of '{thing}' is {known.what}, got {value!r}")
    try:
        numbers = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise wrong from None
    if name == "colour" and numbers.shape == (3,) and np.shape(nominal) == (4,):
        numbers = np.append(numbers, 1.0)
    if name == "gain" and numbers.ndim == 0:
        numbers = np.full(np.shape(nominal), numbers)
    if numbers.shape != np.shape(nominal) or not np.isfinite(numbers).all():
        raise wrong
    if not known.allowed(numbers):
        raise wrong
    return numbers.tolist()
