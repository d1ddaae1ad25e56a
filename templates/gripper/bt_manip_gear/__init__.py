"""A kind of gripper for bt-manip."""
