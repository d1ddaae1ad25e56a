"""Running trees with known traces of the engine: ``python -m bt_manip.bt.conformance PATH...``."""
