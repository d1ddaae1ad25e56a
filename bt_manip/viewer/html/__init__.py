"""Self-contained HTML pages of recorded runs."""

from .markup import html_list as html_list
from .markup import html_page as html_page
from .markup import html_rows as html_rows
from .markup import html_section as html_section
from .markup import html_tiles as html_tiles
from .plots import LONGEST_REASON as LONGEST_REASON
from .plots import PALETTE as PALETTE
from .plots import plain_text as plain_text
from .recorded_run_page import run_page as run_page
