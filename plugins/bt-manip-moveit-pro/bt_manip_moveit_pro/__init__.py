"""Trees of MoveIt Pro: its dialect, its nodes and its sub-trees."""
