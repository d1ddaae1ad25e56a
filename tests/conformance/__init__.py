"""Running trees with known traces of the engine: ``python -m tests.conformance PATH...``."""
