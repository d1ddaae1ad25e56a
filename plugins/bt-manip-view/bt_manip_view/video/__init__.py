"""Videos of runs and of recordings."""

from .export_video import write_video as write_video
from .video_recorder import VideoRecorder as VideoRecorder
