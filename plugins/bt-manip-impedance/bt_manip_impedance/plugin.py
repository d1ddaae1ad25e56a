"""The parts that this package registers."""

from pathlib import Path

from bt_manip import hookimpl

TREES = Path(__file__).parent / "trees"


@hookimpl
def register_objects(register):
    """Register the button."""
    from bt_manip_impedance.push_button import PushButton

    register("push_button", PushButton)


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
    from bt_manip_impedance.insert import Insert, IsInserted
    from bt_manip_impedance.press import IsReleased, Press

    register(Press)
    register(IsReleased)
    register(Insert)
    register(IsInserted)


@hookimpl
def register_scenes(register):
    """Register the button, and the peg with its hole, on the table."""
    from bt_manip_impedance.scene import button_on_table, peg_on_table

    register("button_on_table", button_on_table)
    register("peg_on_table", peg_on_table)


@hookimpl
def register_trees(register):
    """Register the trees, with the scenes and the controller that they need."""
    register(
        "press_button",
        TREES / "press_button.xml",
        scene="button_on_table",
        controller="cartesian_impedance",
    )
    register("insert_peg", TREES / "insert_peg.xml", scene="peg_on_table")
