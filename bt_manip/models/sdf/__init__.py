"""Conversion of SDF, Gazebo's format, to MJCF."""

from bt_manip.models.sdf.convert import convert_sdf as convert_sdf
