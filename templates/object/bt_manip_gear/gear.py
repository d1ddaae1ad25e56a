"""The object."""

from dm_control import composer, mjcf


class Gear(composer.Entity):
    """A round object to pick up; its origin is its centre."""

    kind = "gear"  # its registered name
    category = "graspable"  # its use by behaviours
    free = True  # it moves freely

    def _build(self, name="gear", radius=0.025, height=0.05, mass=0.1):
        self._root = mjcf.RootElement(model=name)
        self._root.worldbody.add(
            "geom", name="body", type="cylinder", size=(radius, height / 2), mass=mass,
            solref=(0.004, 1), friction=(0.8,), rgba=(0.2, 0.5, 0.3, 1),
        )  # fmt: skip
        self.parameters = {"radius": radius, "height": height, "mass": mass}

    @property
    def mjcf_model(self):
        """The model that composer attaches."""
        return self._root

    @property
    def rest_height(self):
        """Height of its centre above its support [m]."""
        return self.parameters["height"] / 2
