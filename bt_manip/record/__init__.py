"""Records of a run: reports, recordings and tables; writing and reading them.

Each name is imported on first use: a report does not need the physics.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from bt_manip.record.figures import CycleFigures as CycleFigures
    from bt_manip.record.figures import ExecutionLog as ExecutionLog
    from bt_manip.record.figures import Interval as Interval
    from bt_manip.record.figures import LoggedNode as LoggedNode
    from bt_manip.record.files import FileInUseError as FileInUseError
    from bt_manip.record.files import RecordingError as RecordingError
    from bt_manip.record.files import check_exists as check_exists
    from bt_manip.record.files import check_writable as check_writable
    from bt_manip.record.files import open_output as open_output
    from bt_manip.record.files import reading as reading
    from bt_manip.record.files import whole_file as whole_file
    from bt_manip.record.files import writing as writing
    from bt_manip.record.identification import identify as identify
    from bt_manip.record.identification import identity_differences as identity_differences
    from bt_manip.record.mcap.camera_images import parse_size as parse_size
    from bt_manip.record.mcap.continuation import Continuation as Continuation
    from bt_manip.record.mcap.continuation import RecordedInterventions as RecordedInterventions
    from bt_manip.record.mcap.export_mcap import write_mcap as write_mcap
    from bt_manip.record.mcap.mcap_recorder import McapRecorder as McapRecorder
    from bt_manip.record.mcap.recorded_run import RecordedRun as RecordedRun
    from bt_manip.record.mcap.recorded_run import running_leaves as running_leaves
    from bt_manip.record.mcap.recorded_scene import RecordedScene as RecordedScene
    from bt_manip.record.mcap.recording import Recording as Recording
    from bt_manip.record.mcap.timeline import Timeline as Timeline
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
    from bt_manip.record.report.run_snapshot import SnapshotWriter as SnapshotWriter
    from bt_manip.record.report.run_snapshot import read_snapshot as read_snapshot
    from bt_manip.record.report.run_snapshot import restore_snapshot as restore_snapshot
    from bt_manip.record.tables.export_table import write_csv as write_csv
    from bt_manip.record.tables.export_table import write_parquet as write_parquet
    from bt_manip.record.tables.trace import Trace as Trace
    from bt_manip.record.tables.trace import read_trace as read_trace
    from bt_manip.record.tables.trace import write_trace as write_trace

__getattr__ = lazy_exports(
    __name__,
    {
        "bt_manip.record.figures": "CycleFigures ExecutionLog Interval LoggedNode",
        "bt_manip.record.files": (
            "FileInUseError RecordingError check_exists check_writable open_output reading "
            "whole_file writing"
        ),
        "bt_manip.record.identification": "identify identity_differences",
        "bt_manip.record.mcap.camera_images": "parse_size",
        "bt_manip.record.mcap.continuation": "Continuation RecordedInterventions",
        "bt_manip.record.mcap.export_mcap": "write_mcap",
        "bt_manip.record.mcap.mcap_recorder": "McapRecorder",
        "bt_manip.record.mcap.recorded_run": "RecordedRun running_leaves",
        "bt_manip.record.mcap.recorded_scene": "RecordedScene",
        "bt_manip.record.mcap.recording": "Recording",
        "bt_manip.record.mcap.timeline": "Timeline",
        "bt_manip.record.report.recorder": "Recorder",
        "bt_manip.record.report.report_file": "ReportFile open_report_file read_report",
        "bt_manip.record.report.run_report": (
            "CycleReport GrippedObject LeafTime LeafUse RunReport TrackingPeak cpu_name versions"
        ),
        "bt_manip.record.report.run_snapshot": "SnapshotWriter read_snapshot restore_snapshot",
        "bt_manip.record.tables.export_table": "write_csv write_parquet",
        "bt_manip.record.tables.trace": "Trace read_trace write_trace",
    },
)
