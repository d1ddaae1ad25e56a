"""A new object: a tin, which every behaviour and tree can use by name."""

from typing import Any

from dm_control import composer, mjcf

from bt_manip import build_station
from bt_manip.behaviours import Drop, Grasp, Hover, IsIn, Lift, Reach, SpawnObject
from bt_manip.bt import Sequence, Tree
from bt_manip.plugins import load_plugins


class Tin(composer.Entity):
    """A tin, as a composer entity: it works in any dm_control environment too."""

    kind = "tin"  # its registered name
    category = "graspable"
    free = True  # it moves freely

    def _build(self, name: str = "tin", radius: float = 0.03, mass: float = 0.2) -> None:
        self._mjcf_root = mjcf.RootElement(model=name)
        self._height = 0.06  # [m]; a higher one would touch the palm
        # The fingers touch along lines, not faces: stiff contacts limit penetration.
        self._mjcf_root.worldbody.add(
            "geom", name="tin", type="cylinder", size=(radius, self._height / 2), mass=mass,
            solref=(0.004, 1), friction=(0.8,), rgba=(0.75, 0.15, 0.12, 1),
        )  # fmt: skip
        self._parameters = {"radius": radius, "mass": mass}

    @property
    def mjcf_model(self) -> mjcf.RootElement:
        """The model that composer attaches."""
        return self._mjcf_root

    @property
    def parameters(self) -> dict[str, Any]:
        """Its keyword arguments, to recreate it from a snapshot."""
        return self._parameters

    @property
    def rest_height(self) -> float:
        """Height of its centre above its support [m]."""
        return self._height / 2


def main() -> None:
    """Let the Panda pick the tin."""
    parts = load_plugins().parts  # built-in and installed parts
    parts.objects.add("tin", Tin, owner="this example")
    station = build_station(parts, seed=1)
    pick = Sequence(
        "pick a tin",
        SpawnObject(model="tin", object="{tin}"),
        Hover(object="{tin}", height=0.15),
        Reach(object="{tin}"),
        Grasp(object="{tin}", force=40.0),
        Lift(height=0.3),
        Drop(container="basket"),
    )
    tree = Tree(pick, goal=IsIn(object="{tin}", container="basket"))
    print(f"{station.run(tree)}, after {station.cell.time:.2f} s")
    # To share it, register it in a plugin, as ../plugins/bt-manip-impedance does.


if __name__ == "__main__":
    main()
