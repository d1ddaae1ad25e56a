"""The report of a recorded run: one HTML file that needs nothing else."""

from .html_report import html_report as html_report
