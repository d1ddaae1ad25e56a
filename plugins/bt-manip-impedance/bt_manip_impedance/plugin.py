"""What this package brings to bt-manip."""

from pathlib import Path

from bt_manip import hookimpl

TREES = Path(__file__).parent / "trees"


@hookimpl
def register_objects(register):
    """Bring the button."""
    from bt_manip_impedance.push_button import PushButton

    register("push_button", PushButton)


@hookimpl
def register_controllers(register):
    """Bring the compliant controllers."""
    from bt_manip_impedance.cartesian_impedance import CartesianImpedance
    from bt_manip_impedance.joint_impedance import JointImpedance

    register("cartesian_impedance", CartesianImpedance)
    register("joint_impedance", JointImpedance)


@hookimpl
def register_behaviours(register):
    """Bring what presses the button."""
    from bt_manip_impedance.press import Press

    register(Press)


@hookimpl
def register_scenes(register):
    """Bring the button on the table."""
    from bt_manip_impedance.scene import button_on_table

    register("button_on_table", button_on_table)


@hookimpl
def register_trees(register):
    """Bring the tree, which needs a compliant arm and a button."""
    register(
        "press_button",
        TREES / "press_button.xml",
        scene="button_on_table",
        controller="cartesian_impedance",
    )
