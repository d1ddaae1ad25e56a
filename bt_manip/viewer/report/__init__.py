"""Reports of recorded runs and of evaluations: one HTML file that needs nothing else."""

from .html_report import html_report as html_report
from .success_report import success_report as success_report
