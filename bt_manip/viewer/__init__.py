"""Watching a run: in the terminal, or in MuJoCo's own window."""
