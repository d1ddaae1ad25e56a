"""The built-in nodes around one child."""
