"""The report of a run, a JSON file."""
