"""Finding model files: bundled, by path, by address."""
