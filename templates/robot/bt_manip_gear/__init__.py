"""A robot for bt-manip."""
