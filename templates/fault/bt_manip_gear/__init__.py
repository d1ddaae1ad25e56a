"""A fault for bt-manip."""
