"""A backend for bt-manip."""
