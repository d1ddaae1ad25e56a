"""What is written down of a run: reports and traces."""
