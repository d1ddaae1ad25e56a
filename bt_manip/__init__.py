"""Behaviour trees for manipulation: tasks, robot cells and plugins."""
