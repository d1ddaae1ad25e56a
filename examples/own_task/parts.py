"""A hexagonal nut, and a behaviour that chooses the next object to sort."""

import math

from dm_control import composer, mjcf

from bt_manip import hookimpl
from bt_manip.behaviours import CellBehaviour, ObjectInput
from bt_manip.bt import Output, Status
from bt_manip.cell import is_in


class Nut(composer.Entity):
    """A hexagonal nut blank that lies flat; its origin is its centre."""

    kind, free, category = "nut", True, "graspable"
    rest_height = 0.02  # [m]
    parameters = {}

    def _build(self, name="nut", mass=0.08):
        self._model = mjcf.RootElement(model=name)
        radius = 0.024  # [m] of its corners
        corners = [
            (radius * math.cos(k * math.pi / 3), radius * math.sin(k * math.pi / 3), z)
            for z in (-self.rest_height, self.rest_height)
            for k in range(6)
        ]
        vertices = [coordinate for corner in corners for coordinate in corner]
        self._model.asset.add("mesh", name="hexagon", vertex=vertices)
        self._model.worldbody.add(
            "geom",
            type="mesh",
            mesh="hexagon",
            mass=mass,
            rgba=(0.7, 0.6, 0.2, 1),
            solref=(0.004, 1),
        )

    @property
    def mjcf_model(self):
        """The model."""
        return self._model


class ChooseNext(CellBehaviour):
    """Choose the next object that is in no bin, and its bin; fail if all are sorted."""

    left_objects = ObjectInput(list[str], doc="Objects for the left bin: names, patterns, kinds.")
    right_objects = ObjectInput(list[str], doc="Objects for the right bin.")
    object = Output(str, doc="Name of the object.")
    bin = Output(str, doc="Name of its bin.")

    memory = ("_last",)

    _last = -1  # number of the last chosen object

    def update(self):
        """Take the first one after the last chosen object, in a circle."""
        pairs = [(name, "left_bin") for name in self.left_objects]
        pairs += [(name, "right_bin") for name in self.right_objects]
        for number in range(self._last + 1, self._last + 1 + len(pairs)):
            name, bin = pairs[number % len(pairs)]
            if not is_in(self.cell, name, bin):
                self.object, self.bin, self._last = name, bin, number % len(pairs)
                return Status.SUCCESS
        return self.fail("all objects are sorted")


@hookimpl
def register_objects(register):
    """Register the nut."""
    register("nut", Nut)


@hookimpl
def register_behaviours(register):
    """Register the behaviour."""
    register(ChooseNext)
