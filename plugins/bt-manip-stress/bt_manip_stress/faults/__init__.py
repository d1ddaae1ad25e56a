"""Fault injection: disturbances of the cell, the robot and the tree."""
