"""Finding model files: bundled, by path, by address."""

from .bundled import bundled_path as bundled_path
from .bundled import bundled_root as bundled_root
