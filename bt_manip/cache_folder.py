"""The folder in which bt-manip keeps what is slow to compute."""

import os
from pathlib import Path

CACHE_VARIABLE = "BT_MANIP_CACHE"
"""Environment variable with the cache folder."""


def cache_root() -> Path:
    """Return the cache folder."""
    if given := os.environ.get(CACHE_VARIABLE, ""):
        return Path(given)
    import platformdirs

    return platformdirs.user_cache_path("bt_manip")
