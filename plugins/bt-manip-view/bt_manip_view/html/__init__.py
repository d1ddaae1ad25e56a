"""Pages in one HTML file: of a recorded run, and of an evaluation."""
