"""Conversion of SDF, Gazebo's format, to MJCF."""

from bt_manip_fuel.sdf.convert import convert_sdf as convert_sdf
