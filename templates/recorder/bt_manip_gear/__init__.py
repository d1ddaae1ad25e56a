"""A recorder for bt-manip."""
