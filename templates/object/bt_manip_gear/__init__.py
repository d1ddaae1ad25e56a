"""An object for bt-manip."""
