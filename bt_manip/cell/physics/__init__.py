"""The compiled physics of a cell: compilation, caching, overrides and transfer of state."""
