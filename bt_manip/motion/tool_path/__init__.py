"""Paths of the tool: lines and arcs with rounded corners, and joints that follow them."""

from .following import SMOOTH as SMOOTH
from .following import follow_path as follow_path
from .steps import ArcTo as ArcTo
from .steps import LineTo as LineTo
from .steps import Step as Step
from .steps import TurnAbout as TurnAbout
from .tool_path import ToolPath as ToolPath
from .tool_path import tool_paths as tool_paths
