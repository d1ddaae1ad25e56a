"""The built-in leaves."""
