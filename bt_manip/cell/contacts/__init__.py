"""Contact queries, contact events and overlaps."""
