"""The parts that this package registers."""

from collections.abc import Callable
from pathlib import Path

from bt_manip import hookimpl

TREES = Path(__file__).parent / "trees"
SCENES = Path(__file__).parent / "scenes"


@hookimpl
def register_objects(register: Callable[..., None]) -> None:
    """Register the button, the drawer, and the peg with its board."""
    from bt_manip_impedance import Drawer, HoleBoard, Peg, PushButton

    for cls in (PushButton, Drawer, Peg, HoleBoard):
        register(cls.kind, cls)


@hookimpl
def register_controllers(register: Callable[..., None]) -> None:
    """Register the compliant controllers."""
    from bt_manip_impedance import CartesianImpedance, JointImpedance

    for cls in (CartesianImpedance, JointImpedance):
        register(cls.kind, cls)


@hookimpl
def register_behaviours(register: Callable[..., None]) -> None:
    """Register the behaviours: all nodes that the package exports."""
    import bt_manip_impedance
    from bt_manip.bt import Node

    for cls in vars(bt_manip_impedance).values():
        if isinstance(cls, type) and issubclass(cls, Node):
            register(cls)


@hookimpl
def register_scenes(register: Callable[..., None]) -> None:
    """Register the scenes of the tasks."""
    from bt_manip.scenes import scene_of

    for path in sorted(SCENES.glob("*.toml")):
        register(path.stem, scene_of(path))


@hookimpl
def register_trees(register: Callable[..., None]) -> None:
    """Register the trees with their scenes and controllers."""
    for name in ("peg_in_hole", "open_drawer", "hand_over"):
        register(name, TREES / f"{name}.xml", scene=name)
    register("insert_peg", TREES / "insert_peg.xml", scene="peg_on_table")
    controlled = {"scene": "press_button", "controller": "cartesian_impedance"}
    register("press_button", TREES / "press_button.xml", **controlled)
