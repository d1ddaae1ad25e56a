"""Overrides: values of a compiled model that differ from the MJCF."""

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from bt_manip.exceptions import did_you_mean
from bt_manip.spatial import as_numbers

from ..exceptions import CellError
from ..naming import entity_of
from .model_properties import CAMERA, ENTITY, LIGHT, PROPERTIES, ModelProperty, find_property

Values = Mapping[str, Any]
"""Values by property: numbers or lists of numbers."""

_OBJECT = {LIGHT: mujoco.mjtObj.mjOBJ_LIGHT, CAMERA: mujoco.mjtObj.mjOBJ_CAMERA}
_WRITTEN = (
    "body_mass", "body_inertia", "geom_friction", "geom_rgba", "geom_matid",
    "actuator_gainprm", "actuator_biasprm", "dof_frictionloss", "dof_solref", "dof_solimp",
    "light_pos", "light_dir", "light_diffuse", "light_ambient", "light_specular",
    "cam_pos", "cam_quat", "cam_fovy",
)  # fmt: skip
# Fields that mj_setConst derives.
_DERIVED = (
    "body_subtreemass", "body_invweight0", "dof_invweight0", "dof_M0", "tendon_invweight0",
    "tendon_length0", "tendon_lengthspring", "actuator_length0", "actuator_acc0",
    "cam_pos0", "cam_poscom0", "cam_mat0", "light_pos0", "light_poscom0", "light_dir0",
)  # fmt: skip


class Overrides:
    """Values by element and property, for the properties that differ from the MJCF.

    An element is an entity by its name, ``light:NAME`` or ``camera:NAME``.
    """

    def __init__(self) -> None:
        self._values: dict[str, dict[str, Any]] = {}

    def __bool__(self) -> bool:
        """Tell whether there are any overrides."""
        return bool(self._values)

    def get_state(self) -> dict[str, dict[str, Any]]:
        """Return all values as plain data."""
        return {element: dict(values) for element, values in self._values.items()}

    def set_state(self, state: Mapping[str, Values]) -> None:
        """Restore all values."""
        self._values = {element: dict(values) for element, values in state.items()}

    def remove(self, element: str) -> None:
        """Remove the overrides of an element."""
        self._values.pop(element, None)

    def put(self, element: str, values: Values, nominal: mujoco.MjModel) -> None:
        """Add overrides; None removes one.

        Args:
            element: The element.
            values: Values by property.
            nominal: The compiled model.

        Raises:
            CellError: If there is no such element or property, or a value is impossible; nothing is
                changed.
        """
        merged = dict(self._values.get(element, {}))
        for name, value in values.items():
            checked = check_override(nominal, element, name, value)
            if checked is None:
                merged.pop(name, None)
            else:
                merged[name] = checked
        if merged:
            self._values[element] = merged
        else:
            self.remove(element)

    def write(self, model: mujoco.MjModel, nominal: mujoco.MjModel) -> None:
        """Set a model to the nominal model with these overrides.

        Args:
            model: Changed in place.
            nominal: The compiled model.
        """
        for field in (*_WRITTEN, *_DERIVED):
            getattr(model, field)[:] = getattr(nominal, field)
        for element, values in self._values.items():
            kind, ids = _find(nominal, element)
            for name, known in PROPERTIES[kind].items():
                if name in values:
                    known.write(model, nominal, ids, np.asarray(values[name]))
        if any("mass" in values for values in self._values.values()):
            mujoco.mj_setConst(model, mujoco.MjData(model))


def check_override(model: mujoco.MjModel, element: str, name: str, value: Any) -> Any:
    """Check an override and return it as plain data; None, which removes one, is returned as is.

    Raises:
        CellError: If there is no such element or property, or the value is impossible.
    """
    kind, ids = _find(model, element)
    known = find_property(kind, name)
    try:
        nominal = known.read(model, ids)
    except CellError as error:
        raise CellError(f"the {name} of '{element}' cannot be overridden: {error}") from None
    return None if value is None else _checked(element, name, known, nominal, value)


def nominal_value(model: mujoco.MjModel, element: str, name: str) -> Any:
    """Return the value of a property in a model without overrides.

    Raises:
        CellError: If there is no such element or property.
    """
    kind, ids = _find(model, element)
    return find_property(kind, name).read(model, ids)


def _find(model: mujoco.MjModel, element: str) -> tuple[str, np.ndarray]:
    """Return an element's kind, and the ids of its bodies, of the light or of the camera."""
    kind, colon, name = element.partition(":")
    if not colon or kind not in _OBJECT:
        owners = [entity_of(model.body(i).name) for i in range(model.nbody)]
        bodies = np.flatnonzero([owner == element for owner in owners[1:]]) + 1
        if not len(bodies):
            near = did_you_mean(element, dict.fromkeys(owners[1:]))
            raise CellError(f"there is no '{element}' in the cell{near}")
        return ENTITY, bodies
    count = model.nlight if kind == LIGHT else model.ncam
    names = [mujoco.mj_id2name(model, _OBJECT[kind], i) or "" for i in range(count)]
    # A camera entity is addressed by the entity's name.
    short = [n.partition("/")[0] if n.endswith("/eye") else n for n in names]
    for known in (names, short):
        if name in known:
            return kind, np.array([known.index(name)])
    raise CellError(f"there is no {kind} '{name}' in the cell{did_you_mean(name, short)}")


def _checked(element: str, name: str, known: ModelProperty, nominal: Any, value: Any) -> Any:
    """Check a value and return it as plain data."""
    numbers = as_numbers(value)
    if name == "colour" and numbers.shape == (3,) and np.shape(nominal) == (4,):
        numbers = np.append(numbers, 1.0)
    if name == "gain" and numbers.ndim == 0:
        numbers = np.full(np.shape(nominal), numbers)
    finite = numbers.shape == np.shape(nominal) and np.isfinite(numbers).all()
    if not finite or not known.allowed(numbers):
        raise CellError(f"the {name} of '{element}' is {known.what}, got {value!r}")
    return numbers.tolist()
