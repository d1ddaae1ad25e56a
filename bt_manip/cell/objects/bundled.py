"""Objects with bundled models: cube, table, basket."""

import numpy as np
from dm_control import mjcf

from bt_manip.models import bundled_path
from bt_manip.parameters import Parameter

from .prop import Prop, value_of


class BundledProp(Prop):
    """An object with a bundled model file; parameters of None keep the file's value."""

    def _make_model(self, name: str) -> None:
        self._mjcf_root = mjcf.from_path(str(bundled_path(f"{self.kind}/{self.kind}.xml")))
        self._mjcf_root.model = name
        mass, friction, colour = map(self._parameters.get, ("mass", "friction", "colour"))
        if mass is not None:
            share = mass / self.mass
            for geom in self.collision_geoms:
                geom.mass = (value_of(geom, "mass") or 0.0) * share
        if friction is not None:
            self._set_friction(friction)
        if colour is not None:
            self._set_colour(colour)


class Cube(BundledProp):
    """A wooden cube to pick up; its origin is its centre."""

    kind = "cube"
    category = "graspable"
    free = True
    defaults = {
        "size": Parameter("Length of an edge", "m", None, type=float, above=0.0),
        **BundledProp.defaults,
    }

    def _make_model(self, name: str) -> None:
        super()._make_model(name)
        size = self._parameters["size"]
        if size is not None:
            for geom in (*self.collision_geoms, *self.visual_geoms):
                geom.size = [size / 2] * 3

    @property
    def size(self) -> float:
        """Length of an edge [m]."""
        return 2 * float(self.collision_geoms[0].size[0])

    @property
    def rest_height(self) -> float:
        """Height of the centre above its support at rest [m]."""
        return self.size / 2


class Table(BundledProp):
    """A table; its origin is on the floor, under the centre of its top."""

    kind = "table"
    category = "surface"
    defaults = {
        "size": Parameter(
            "Lengths of its top along x and y; by default 1.5 and 0.8", "m", None,
            type=float, size=2, at_least=0.2,
        ),
        "height": Parameter(
            "Height of its surface above the floor; by default 1.015", "m", None,
            type=float, at_least=0.1,
        ),
        **{key: BundledProp.defaults[key] for key in ("friction", "colour")},
    }  # fmt: skip

    def _make_model(self, name: str) -> None:
        super()._make_model(name)
        top, height = self._mjcf_root.find("geom", "top"), self._parameters["height"]
        rise = 0.0 if height is None else height - self.surface_height
        size = self._parameters["size"]
        wider = np.zeros(2) if size is None else np.array(size) / 2 - top.size[:2]
        for geom in self._all_geoms():
            if geom.fromto is None:  # the top
                geom.size = geom.size + np.append(wider, 0.0)
                geom.pos = geom.pos + (0.0, 0.0, rise)
            else:  # a leg: its lower end, then its upper one
                ends = np.reshape(geom.fromto, (2, 3))
                ends[:, :2] += wider * np.sign(ends[:, :2])
                ends[1, 2] += rise
                geom.fromto = ends.ravel()

    @property
    def surface_height(self) -> float:
        """Height of the surface above the origin [m]."""
        top = self._mjcf_root.find("geom", "top")
        return float(top.pos[2] + top.size[2])


class Basket(BundledProp):
    """An open basket to drop objects into; its origin is the centre of its bottom."""

    kind = "basket"
    category = "container"
