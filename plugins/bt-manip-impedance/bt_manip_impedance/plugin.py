"""The parts that this package registers."""

from pathlib import Path

from bt_manip import hookimpl

TREES = Path(__file__).parent / "trees"
SCENES = Path(__file__).parent / "scenes"


@hookimpl
def register_objects(register):
    """Register the button, the drawer, and the peg with its board."""
    from bt_manip_impedance.drawer import Drawer
    from bt_manip_impedance.peg_and_board import HoleBoard, Peg
    from bt_manip_impedance.push_button import PushButton

    register("push_button", PushButton)
    register("drawer", Drawer)
    register("peg", Peg)
    register("hole_board", HoleBoard)


@hookimpl
def register_controllers(register):
    """Register the compliant controllers."""
    from bt_manip_impedance.cartesian_impedance import CartesianImpedance
    from bt_manip_impedance.joint_impedance import JointImpedance

    register("cartesian_impedance", CartesianImpedance)
    register("joint_impedance", JointImpedance)


@hookimpl
def register_behaviours(register):
    """Register the behaviours that need a compliant controller."""
    from bt_manip_impedance.hand_over import FindFreeEnd, HoldOut, IsHandedOver
    from bt_manip_impedance.insert import Insert, IsInserted
    from bt_manip_impedance.open_drawer import IsOpen, PullOpen, ReachHandle
    from bt_manip_impedance.press import IsReleased, Press, WasPressed

    for behaviour in (
        Press, IsReleased, WasPressed, Insert, IsInserted, ReachHandle, PullOpen, IsOpen,
        FindFreeEnd, HoldOut, IsHandedOver,
    ):  # fmt: skip
        register(behaviour)


@hookimpl
def register_scenes(register):
    """Register the scenes of the tasks."""
    from bt_manip.scenes import scene_of

    for path in sorted(SCENES.glob("*.toml")):
        register(path.stem, scene_of(path))


@hookimpl
def register_trees(register):
    """Register the trees with their scenes and controllers."""
    register(
        "press_button",
        TREES / "press_button.xml",
        scene="press_button",
        controller="cartesian_impedance",
    )
    register("insert_peg", TREES / "insert_peg.xml", scene="peg_on_table")
    for name in ("peg_in_hole", "open_drawer", "hand_over"):
        register(name, TREES / f"{name}.xml", scene=name)
