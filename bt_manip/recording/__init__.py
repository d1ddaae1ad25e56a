"""Report, trace and digest of a run.

Each name is imported on first use: the report does not need the physics.
"""

from typing import TYPE_CHECKING

from bt_manip.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from bt_manip.recording.continuation import Continuation as Continuation
    from bt_manip.recording.continuation import RecordedInterventions as RecordedInterventions
    from bt_manip.recording.export_mcap import write_mcap as write_mcap
    from bt_manip.recording.export_table import running_leaves as running_leaves
    from bt_manip.recording.export_table import write_csv as write_csv
    from bt_manip.recording.export_table import write_parquet as write_parquet
    from bt_manip.recording.export_video import write_video as write_video
    from bt_manip.recording.files import RecordingError as RecordingError
    from bt_manip.recording.files import check_writable as check_writable
    from bt_manip.recording.files import reading as reading
    from bt_manip.recording.files import whole_file as whole_file
    from bt_manip.recording.files import writing as writing
    from bt_manip.recording.identification import identify as identify
    from bt_manip.recording.identification import identity_differences as identity_differences
    from bt_manip.recording.mcap_recorder import McapRecorder as McapRecorder
    from bt_manip.recording.recorded_run import Interval as Interval
    from bt_manip.recording.recorded_run import RecordedCycle as RecordedCycle
    from bt_manip.recording.recorded_run import RecordedRun as RecordedRun
    from bt_manip.recording.recorded_scene import RecordedScene as RecordedScene
    from bt_manip.recording.recorder import Recorder as Recorder
    from bt_manip.recording.recorder import next_digest as next_digest
    from bt_manip.recording.recording import Recording as Recording
    from bt_manip.recording.report import CycleReport as CycleReport
    from bt_manip.recording.report import GrippedObject as GrippedObject
    from bt_manip.recording.report import RunReport as RunReport
    from bt_manip.recording.report import TrackingPeak as TrackingPeak
    from bt_manip.recording.report import cpu_name as cpu_name
    from bt_manip.recording.report import versions as versions
    from bt_manip.recording.report_file import ReportFile as ReportFile
    from bt_manip.recording.report_file import open_report_file as open_report_file
    from bt_manip.recording.report_file import read_report as read_report
    from bt_manip.recording.run_snapshot import SnapshotAt as SnapshotAt
    from bt_manip.recording.run_snapshot import restore_snapshot as restore_snapshot
    from bt_manip.recording.timeline import Timeline as Timeline
    from bt_manip.recording.trace import Trace as Trace
    from bt_manip.recording.trace import TraceRecorder as TraceRecorder
    from bt_manip.recording.trace import read_trace as read_trace
    from bt_manip.recording.video import VideoRecorder as VideoRecorder
    from bt_manip.recording.video import parse_size as parse_size

__getattr__ = lazy_exports(__name__)
