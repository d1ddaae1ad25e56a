"""The commands ``view``, ``replay`` and ``report``."""
