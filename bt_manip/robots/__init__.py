"""Robots: description, composer entity and the Pinocchio model that agrees with MuJoCo."""
