"""Groot2: a publisher for its live monitor, and its log files."""

from .log_files import BtlogRecorder as BtlogRecorder
from .log_files import SqliteRecorder as SqliteRecorder
from .log_files import write_btlog as write_btlog
from .log_files import write_sqlite as write_sqlite
from .publisher import GrootPublisher as GrootPublisher
