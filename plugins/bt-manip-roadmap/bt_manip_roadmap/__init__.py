"""A planner that finds the shortest path in a probabilistic roadmap."""

from bt_manip_roadmap.lazy_roadmap import LazyRoadmap as LazyRoadmap
