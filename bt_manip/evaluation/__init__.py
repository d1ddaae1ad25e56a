"""Episodes of a tree in parallel processes, and their success.

Each name is imported on first use: running episodes needs neither the physics nor Parquet.
"""

from typing import TYPE_CHECKING

from bt_manip.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from bt_manip.evaluation.engine import Pool as Pool
    from bt_manip.evaluation.engine import ProcessPool as ProcessPool
    from bt_manip.evaluation.engine import Worker as Worker
    from bt_manip.evaluation.engine import WorkerDiedError as WorkerDiedError
    from bt_manip.evaluation.engine import run_episodes as run_episodes

__getattr__ = lazy_exports(__name__)
