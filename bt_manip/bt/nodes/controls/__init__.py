"""The built-in nodes with several children."""
