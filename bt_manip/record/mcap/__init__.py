"""Recordings, MCAP files: writing, reading, and continuing runs from them."""
