"""Let tests import the module that writes ONNX files."""

import sys
from pathlib import Path

from tests.support.drawing import opengl as opengl

sys.path.insert(0, str(Path(__file__).parent))
