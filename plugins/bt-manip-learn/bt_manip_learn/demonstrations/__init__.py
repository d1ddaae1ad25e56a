"""Demonstrations by a tree as the expert, for imitation learning.

Each name is imported on first use: reading demonstrations needs no physics.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from .export_lerobot import write_lerobot as write_lerobot
    from .export_minari import write_minari as write_minari
    from .export_parquet import write_demonstration_table as write_demonstration_table
    from .export_robomimic import write_robomimic as write_robomimic
    from .recorder import DemonstrationRecorder as DemonstrationRecorder
    from .store import Demonstration as Demonstration
    from .store import DemonstrationStore as DemonstrationStore
    from .store import read_demonstrations as read_demonstrations

__getattr__ = lazy_exports(__name__)
