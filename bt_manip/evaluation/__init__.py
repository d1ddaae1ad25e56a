"""Episodes of a tree in parallel processes, and their success.

Each name is imported on first use: running episodes needs neither the physics nor Parquet.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from bt_manip.evaluation.engine import ProcessPool as ProcessPool
    from bt_manip.evaluation.engine import Worker as Worker
    from bt_manip.evaluation.engine import WorkerDiedError as WorkerDiedError
    from bt_manip.evaluation.engine import call_in_process as call_in_process
    from bt_manip.evaluation.engine import portable as portable
    from bt_manip.evaluation.engine import run_episodes as run_episodes
    from bt_manip.evaluation.episode import EpisodeId as EpisodeId
    from bt_manip.evaluation.episode import EpisodeResult as EpisodeResult
    from bt_manip.evaluation.episode import EpisodeWorker as EpisodeWorker
    from bt_manip.evaluation.episode import Evaluation as Evaluation
    from bt_manip.evaluation.feasibility import why_not as why_not
    from bt_manip.evaluation.paired import PairedTable as PairedTable
    from bt_manip.evaluation.paired import mcnemar_p_value as mcnemar_p_value
    from bt_manip.evaluation.paired import newcombe_interval as newcombe_interval
    from bt_manip.evaluation.results import ResultFolder as ResultFolder
    from bt_manip.evaluation.results import read_results as read_results
    from bt_manip.evaluation.scheduling import evaluate as evaluate
    from bt_manip.evaluation.success import Failure as Failure
    from bt_manip.evaluation.success import SuccessRate as SuccessRate
    from bt_manip.evaluation.success import wilson_interval as wilson_interval
    from bt_manip.evaluation.variation import VariedParameter as VariedParameter
    from bt_manip.evaluation.variation import grid as grid
    from bt_manip.evaluation.variation import parse_parameter as parse_parameter
    from bt_manip.evaluation.variation import parse_point as parse_point
    from bt_manip.evaluation.variation import samples as samples

__getattr__ = lazy_exports(__name__)
