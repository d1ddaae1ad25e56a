"""A planner for bt-manip."""
