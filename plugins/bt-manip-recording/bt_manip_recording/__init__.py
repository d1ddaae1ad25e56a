"""Recordings of runs, MCAP files and traces: writing, reading, and continuing runs from them.

Names are imported on first use: writing a recording needs nothing of what reads one.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from bt_manip_recording.camera_images import jpeg as jpeg
    from bt_manip_recording.continuation import Continuation as Continuation
    from bt_manip_recording.continuation import RecordedInterventions as RecordedInterventions
    from bt_manip_recording.export_mcap import write_mcap as write_mcap
    from bt_manip_recording.export_table import write_csv as write_csv
    from bt_manip_recording.export_table import write_npz as write_npz
    from bt_manip_recording.export_table import write_parquet as write_parquet
    from bt_manip_recording.foxglove import timestamp_of as timestamp_of
    from bt_manip_recording.log_lines import log_line as log_line
    from bt_manip_recording.mcap_recorder import McapRecorder as McapRecorder
    from bt_manip_recording.past_states import record_states as record_states
    from bt_manip_recording.recorded_run import RecordedRun as RecordedRun
    from bt_manip_recording.recorded_run import running_leaves as running_leaves
    from bt_manip_recording.recorded_scene import RecordedScene as RecordedScene
    from bt_manip_recording.recording import Recording as Recording
    from bt_manip_recording.textured_mesh import TexturedMesh as TexturedMesh
    from bt_manip_recording.timeline import Timeline as Timeline
    from bt_manip_recording.tool_paths import tool_path as tool_path
    from bt_manip_recording.trace import Trace as Trace
    from bt_manip_recording.trace import read_trace as read_trace
    from bt_manip_recording.trace import write_trace as write_trace
    from bt_manip_recording.visuals import PLANE_THICKNESS as PLANE_THICKNESS
    from bt_manip_recording.visuals import CellScene as CellScene
    from bt_manip_recording.visuals import SceneCamera as SceneCamera
    from bt_manip_recording.visuals import SceneSource as SceneSource
    from bt_manip_recording.visuals import Triangles as Triangles
    from bt_manip_recording.visuals import VisualShape as VisualShape

__getattr__ = lazy_exports(__name__)
