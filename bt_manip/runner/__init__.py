"""The one loop: a tree, a cell, a clock."""
