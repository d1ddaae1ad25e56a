"""Learning from and for the trees of bt-manip: agents, environments, demonstrations."""
