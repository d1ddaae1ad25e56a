"""Demonstrations by a tree as the expert, for imitation learning.

Each name is imported on first use: reading demonstrations needs no physics.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from bt_manip.demonstrations.export_lerobot import write_lerobot as write_lerobot
    from bt_manip.demonstrations.export_parquet import (
        write_demonstration_table as write_demonstration_table,
    )
    from bt_manip.demonstrations.export_robomimic import write_robomimic as write_robomimic
    from bt_manip.demonstrations.recorder import DemonstrationRecorder as DemonstrationRecorder
    from bt_manip.demonstrations.store import Demonstration as Demonstration
    from bt_manip.demonstrations.store import DemonstrationStore as DemonstrationStore
    from bt_manip.demonstrations.store import read_demonstrations as read_demonstrations

__getattr__ = lazy_exports(
    __name__,
    {
        "bt_manip.demonstrations.export_lerobot": "write_lerobot",
        "bt_manip.demonstrations.export_parquet": "write_demonstration_table",
        "bt_manip.demonstrations.export_robomimic": "write_robomimic",
        "bt_manip.demonstrations.recorder": "DemonstrationRecorder",
        "bt_manip.demonstrations.store": "Demonstration DemonstrationStore read_demonstrations",
    },
)
