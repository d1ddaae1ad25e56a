"""Records of a run: its report and its figures; writing and reading them.

Each name is imported on first use: a report does not need the physics.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from bt_manip.record.figures import CycleFigures as CycleFigures
    from bt_manip.record.figures import ExecutionLog as ExecutionLog
    from bt_manip.record.figures import Interval as Interval
    from bt_manip.record.figures import LoggedNode as LoggedNode
    from bt_manip.record.figures import RobotFigures as RobotFigures
    from bt_manip.record.figures import RobotState as RobotState
    from bt_manip.record.figures import RunFigures as RunFigures
    from bt_manip.record.figures import StepFigures as StepFigures
    from bt_manip.record.figures import live_state as live_state
    from bt_manip.record.files import AppendedFile as AppendedFile
    from bt_manip.record.files import FileInUseError as FileInUseError
    from bt_manip.record.files import RecordingError as RecordingError
    from bt_manip.record.files import check_exists as check_exists
    from bt_manip.record.files import check_writable as check_writable
    from bt_manip.record.files import is_special as is_special
    from bt_manip.record.files import open_output as open_output
    from bt_manip.record.files import reading as reading
    from bt_manip.record.files import whole_file as whole_file
    from bt_manip.record.files import writing as writing
    from bt_manip.record.identification import identify as identify
    from bt_manip.record.identification import identity_differences as identity_differences
    from bt_manip.record.report.recorder import Recorder as Recorder
    from bt_manip.record.report.report_file import ReportFile as ReportFile
    from bt_manip.record.report.report_file import open_report_file as open_report_file
    from bt_manip.record.report.report_file import read_report as read_report
    from bt_manip.record.report.run_report import CycleReport as CycleReport
    from bt_manip.record.report.run_report import GrippedObject as GrippedObject
    from bt_manip.record.report.run_report import LeafTime as LeafTime
    from bt_manip.record.report.run_report import LeafUse as LeafUse
    from bt_manip.record.report.run_report import RunReport as RunReport
    from bt_manip.record.report.run_report import TrackingPeak as TrackingPeak
    from bt_manip.record.report.run_report import cpu_name as cpu_name
    from bt_manip.record.report.run_report import versions as versions
    from bt_manip.record.report.run_snapshot import SnapshotAt as SnapshotAt
    from bt_manip.record.report.run_snapshot import SnapshotWriter as SnapshotWriter
    from bt_manip.record.report.run_snapshot import read_snapshot as read_snapshot
    from bt_manip.record.report.run_snapshot import restore_snapshot as restore_snapshot
    from bt_manip.record.report.run_snapshot import take_snapshot as take_snapshot

__getattr__ = lazy_exports(__name__)
