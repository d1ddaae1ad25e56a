"""Groot2 for bt-manip: a publisher for its live monitor, and its log files."""
