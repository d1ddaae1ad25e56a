"""A controller for bt-manip."""
