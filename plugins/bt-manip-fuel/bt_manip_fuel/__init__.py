"""SDFormat, and the models of Gazebo Fuel, for bt-manip."""
