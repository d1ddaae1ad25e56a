"""Groot2: a publisher for its live monitor, and its log files."""

from .publisher import GrootPublisher as GrootPublisher
