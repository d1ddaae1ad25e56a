"""The command line; its modules import nothing heavy before a command runs."""
