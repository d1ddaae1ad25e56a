"""A panel for bt-manip."""
