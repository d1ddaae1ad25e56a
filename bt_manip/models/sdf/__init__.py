"""SDF, Gazebo's format, turned into MJCF."""

from bt_manip.models.sdf.convert import convert_sdf as convert_sdf
