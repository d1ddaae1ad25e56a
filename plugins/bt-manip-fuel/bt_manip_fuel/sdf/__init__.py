"""Conversion of SDF, Gazebo's format, to MJCF."""
