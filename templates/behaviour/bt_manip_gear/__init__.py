"""A behaviour for bt-manip."""
