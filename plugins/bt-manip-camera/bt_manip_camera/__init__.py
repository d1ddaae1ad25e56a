"""Cameras with the errors of real ones for bt-manip, and poses from their depth images."""
