"""The nodes of a tree: base classes, and the built-in ones."""
