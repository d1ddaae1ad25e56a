"""The cell: a composer arena, its objects, its compiled physics and its contacts."""
