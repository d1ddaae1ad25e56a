"""Leaves of trees: hover, reach, grasp, lift, drop and their kin."""
