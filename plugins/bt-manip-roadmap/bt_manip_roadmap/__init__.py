"""A planner that looks for the shortest way on a roadmap."""

from bt_manip_roadmap.lazy_roadmap import LazyRoadmap as LazyRoadmap
