"""What touches what: contact queries, contact events, overlaps."""
