"""Objects from any model address."""

import contextlib
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from dm_control import mjcf

from bt_manip.exceptions import one_line
from bt_manip.models import MjcfModel, check_mjcf, exact_xml, load_model, scaled_model
from bt_manip.parameters import Parameter

from ..exceptions import CellError
from ..naming import name_elements
from .bounds import Bounds, bounds_of
from .categories import CONTAINER, check_spelling
from .plausibility import correct_inertias, invented_masses
from .prop import Prop, value_of

GRIPPABLE = 0.08
"""Largest opening of common grippers [m]."""
_LARGE, _SMALL = 2.0, 1e-3  # [m] longest edge above or below which the unit may be wrong
_PORTABLE = 0.5  # [m] longest edge of models that are free by default
_FLAT = 0.3  # [m] shortest horizontal edge of surfaces
_READ = {"angle", "autolimits", "meshdir", "texturedir", "assetdir"}
"""Settings of MJCF's compiler that PyMJCF applies to one model of several."""
_OF_CLASS = ("geom", "joint", "site", "actuator", "equality", "tendon", "mesh", "material")
_WORLD_SETTINGS = ("option", "visual", "statistic", "size", "keyframe")


class ModelObject(Prop):
    """An object from a model file, or a model of Menagerie or Fuel.

    Its properties are derived from the model. It is free if the model says so (SDF: not
    ``static``; MJCF: a free joint); if the model does not say, it is free if it has no joints and
    is at most 0.5 m long. By default its category is ``graspable`` if it is free and fits into
    common grippers, ``surface`` if it is fixed and large, and ``thing`` otherwise. Settings of the
    world in the file (options, keyframes) are dropped.
    """

    warnings: tuple[str, ...]
    """What is strange in its file, or was lost in its conversion."""

    _bounds: Bounds
    _mass: float

    defaults = {
        **Prop.defaults,
        "category": Parameter("What behaviours may do with it: graspable, ...", "", None, type=str),
        "convex": Parameter(
            "What meshes of an address collide by: their hull, or convex parts, without which "
            "nothing fits into a hollow one; by default hull", "", None, type=str,
        ),
        "scale": Parameter(
            "Factor of its lengths, 0.001 for a file in millimetres; masses in the file stay",
            "", None, type=float, above=0.0,
        ),
    }  # fmt: skip

    def _build(  # type: ignore[override]
        self, model: str | MjcfModel, name: str | None = None, **parameters: Any
    ) -> None:
        """Load the model; ``None`` keeps its own value.

        Args:
            model: An address, or a loaded model.
            name: Model name.
            parameters: Values of those in ``defaults``.

        Raises:
            ModelError: If there is no model at the address.
            CellError: If MuJoCo rejects the model, or a parameter is invalid.
        """
        self._take(parameters)
        mass, friction, colour, category, convex, scale = self._parameters.values()
        if category is not None:
            check_spelling(category)
        if isinstance(model, str):
            model = load_model(model, convex=convex or "hull")
        self.kind = model.address
        if scale is not None:
            model = scaled_model(model, scale)
        self._mjcf_root = root = mjcf_root(model)
        root.model = name or model.name
        implicit = root.option.integrator in ("implicit", "implicitfast")
        loose = _drop_world(root)
        name_elements(root)
        alone = self._compile(model)
        warnings = [f"{self.kind}: {text}" for text in correct_inertias(root, alone)]
        if warnings:
            alone = self._compile(model)
        if implicit:
            _damp_joints(root, alone)
        self._touchable = {
            alone.geom(i).name
            for i in range(alone.ngeom)
            if alone.geom_contype[i] or alone.geom_conaffinity[i]
        }
        self._bounds = bounds_of(alone)
        self._mass = float(alone.body_mass[1:].sum())
        if mass is not None:
            if self._mass <= 0:
                raise CellError(f"'{self.kind}' has no mass to change")
            _scale_mass(root, mass / self._mass)
            self._mass = float(mass)
        if friction is not None:
            self._set_friction(friction)
        if colour is not None:
            self._set_colour(colour)
        self.free = self._find_free(model, loose > 0, alone)
        if loose > 1:
            warnings.append(f"{self.kind}: its {loose} free bodies move as one, not by themselves")
        if self.free and not self._touchable:
            warnings.append(f"{self.kind}: nothing of it collides, so it falls through all others")
        if mass is None and (invented := invented_masses(root, alone, fixed=not self.free)):
            warnings.append(f"{self.kind}: {invented}; mass = ... gives it")
        longest = float(self._bounds.size.max())
        if longest > _LARGE or 0.0 < longest < _SMALL:
            size = " x ".join(f"{edge:.4g}" for edge in self._bounds.size)
            scaled = f"scale = 0.001, or {self.kind}?scale=0.001, reads millimetres"
            warnings.append(f"{self.kind}: its size is {size} m; {scaled}")
        self.warnings = (*model.warnings, *warnings)
        self.category = category or self._find_category()

    @property
    def mass(self) -> float:
        """Total mass [kg]."""
        return self._mass

    @property
    def bounds(self) -> Bounds:
        """Bounding box of the collision shapes, aligned with its own frame."""
        return self._bounds

    @property
    def rest_height(self) -> float:
        """Height of the origin above its support at rest [m]."""
        return -float(self._bounds.lower[2])

    @property
    def centre_offset(self) -> np.ndarray:
        """Centre of its bounding box, in its own frame [m]."""  # (3,)
        return self._bounds.centre

    @property
    def surface_height(self) -> float | None:
        """Height of its top above the origin [m]; None for containers."""
        return None if self.category == CONTAINER else float(self._bounds.upper[2])

    def _compile(self, model: MjcfModel) -> mujoco.MjModel:
        try:
            root = self._mjcf_root
            return mujoco.MjModel.from_xml_string(root.to_xml_string(), root.get_assets())
        except ValueError as error:
            raise CellError(f"{model.address}: MuJoCo refuses it: {one_line(error)}") from error

    def _collides(self, geom: mjcf.Element) -> bool:
        return geom.full_identifier in self._touchable

    def _find_free(self, model: MjcfModel, loose: bool, alone: mujoco.MjModel) -> bool:
        if loose or model.static is not None:
            return loose or not model.static
        solid = self._mass > 0 or bool(self._touchable)  # what only looks like something is fixed
        return alone.njnt == 0 and solid and bool(self._bounds.size.max() <= _PORTABLE)

    def _find_category(self) -> str:
        size = self._bounds.size
        if self.free:
            return "graspable" if size[:2].min() <= GRIPPABLE else "thing"
        return "surface" if size[:2].min() >= _FLAT else "thing"


def mjcf_root(model: MjcfModel) -> mjcf.RootElement:
    """Read a model into PyMJCF, with angles in radians.

    The angles of an attached model are read in the arena's unit, so MuJoCo's own writer converts
    degrees to radians first, and resolves what PyMJCF does not know, such as frames.

    Raises:
        CellError: If it cannot be read.
        ModelError: If it, or a file that it names, may not be read.
    """
    files = set() if model.path is None else check_mjcf(model.path)
    try:
        root = _root(model, files)
    except Exception as error:  # PyMJCF raises errors of any type
        reason = one_line(error) or type(error).__name__
        raise CellError(f"{model.address}: cannot be read: {reason}") from error
    for part in (part for kind in _OF_CLASS for part in root.find_all(kind)):
        if isinstance(getattr(part, "dclass", None), str):  # "main", which PyMJCF does not find
            part.dclass = root.default
    return root


def _root(model: MjcfModel, files: set[Path]) -> mjcf.RootElement:
    """Read a model, given the files of those that it attaches."""
    folder = "" if model.path is None else str(model.path.parent)
    if model.path is None or model.xml:
        return mjcf.from_xml_string(
            model.xml, assets=dict(model.assets), model_dir=folder, escape_separators=True
        )
    with contextlib.suppress(Exception):  # frames, and whatever else only MuJoCo knows
        root = mjcf.from_path(str(model.path), escape_separators=True)
        given = root.compiler.get_attributes()
        if given.get("angle") == "radian" and given.keys() <= _READ:
            return root
    spec = mujoco.MjSpec.from_file(str(model.path))
    return mjcf.from_xml_string(exact_xml(spec, files), model_dir=folder, escape_separators=True)


def _drop_world(root: mjcf.RootElement) -> int:
    """Remove settings of the world; return the number of its free joints."""
    if root.deformable.all_children():
        raise CellError(f"'{root.model}' has soft bodies (flex, skin), which are not supported")
    for setting in _WORLD_SETTINGS:
        getattr(root, setting).remove()
    for light in root.worldbody.find_all("light", immediate_children_only=True):
        light.remove()
    loose = 0
    for body in root.worldbody.find_all("body", immediate_children_only=True):
        body.mocap = None
        free = [body.freejoint] if body.freejoint is not None else []
        free += [joint for joint in body.find_all("joint", immediate_children_only=True)
                 if joint.tag == "joint" and joint.type == "free"]  # fmt: skip
        for joint in free:
            joint.remove()
            loose += 1
    return loose


def _damp_joints(root: mjcf.RootElement, alone: mujoco.MjModel) -> None:
    """Move the damping of actuators to the joints, for models with an implicit integrator.

    The arena's integrator is implicit in the damping of joints but not of actuators, so stiff
    servos of such a model would be unstable. Forces are the same except for their limits.
    """
    joint_type = int(mujoco.mjtTrn.mjTRN_JOINT)
    for i, actuator in enumerate(root.find_all("actuator")):
        braking = -float(alone.actuator_biasprm[i, 2])
        if int(alone.actuator_trntype[i]) != joint_type or braking <= 0:
            continue
        dof = int(alone.jnt_dofadr[alone.actuator_trnid[i, 0]])
        gear = float(alone.actuator_gear[i, 0])
        actuator.joint.damping = float(alone.dof_damping[dof]) + braking * gear**2
        if actuator.tag == "position":
            actuator.kv, actuator.dampratio = 0.0, None
        elif actuator.tag == "general":
            actuator.biasprm = (*alone.actuator_biasprm[i, :2], 0.0)


def _scale_mass(root: mjcf.RootElement, share: float) -> None:
    """Multiply all masses and inertias by a factor."""
    for body in root.find_all("body"):
        if body.inertial is None:
            for geom in body.find_all("geom", immediate_children_only=True):
                density = value_of(geom, "density")
                if (mass := value_of(geom, "mass")) is not None:
                    geom.mass = mass * share
                else:
                    geom.density = (1000.0 if density is None else density) * share
            continue
        body.inertial.mass *= share
        for moments in ("diaginertia", "fullinertia"):
            value = getattr(body.inertial, moments)
            if value is not None:
                setattr(body.inertial, moments, value * share)
