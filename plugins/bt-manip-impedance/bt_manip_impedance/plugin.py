"""What this package brings to bt-manip."""

from bt_manip import hookimpl


@hookimpl
def register_objects(register):
    """Bring the button."""
    from bt_manip_impedance.push_button import PushButton

    register("push_button", PushButton)


@hookimpl
def register_controllers(register):
    """Bring the compliant controller."""
    from bt_manip_impedance.joint_impedance import JointImpedance

    register("joint_impedance", JointImpedance)
