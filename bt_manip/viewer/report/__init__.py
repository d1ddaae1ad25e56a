"""The report of a recorded run: one HTML file that needs nothing else."""

from .html_report import html_report as html_report
from .html_report import write_html_report as write_html_report
