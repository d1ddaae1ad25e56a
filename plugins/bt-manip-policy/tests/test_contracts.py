"""Everything that the package brings keeps the contracts of its kind."""

import atexit
import tempfile
from pathlib import Path

from bt_manip.testing import trees_of
from bt_manip_contracts import Example, contracts_of

from . import onnx_files as onnx

_FOLDER = tempfile.TemporaryDirectory()
atexit.register(_FOLDER.cleanup)
IDLE = Path(_FOLDER.name) / "idle.onnx"
IDLE.write_bytes(onnx.linear([0.002, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0], {"robot_tool_position": (3,)}))

SETTINGS = {"pick_place_policy": {"policy": str(IDLE)}}

test_contracts = contracts_of(
    "policy",
    settings=SETTINGS,
    examples={
        "RunPolicy": Example(
            ports={"model": str(IDLE), "time_limit": 0.5},
            status="FAILURE",
            fails=({"time_limit": -1.0},),
        ),
        "IsAbove": Example(ports={"object": "basket", "support": "table"}, status="FAILURE"),
    },
)


test_trees = trees_of("policy", settings=SETTINGS)
