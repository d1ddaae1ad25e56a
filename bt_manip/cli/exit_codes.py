"""Exit codes of all commands."""

SUCCESS = 0

FAILED = 1
"""A cycle or an episode failed, or a check found problems."""

BAD_INPUT = 2
"""Bad input or usage; nothing was simulated."""

FAULT = 3
"""An internal fault: a plugin raised, the physics diverged, a file could not be written."""

INTERRUPTED = 130
"""After Ctrl-C: 128 + SIGINT, as in shells."""
