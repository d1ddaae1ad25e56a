"""Videos, of runs and of recordings."""
