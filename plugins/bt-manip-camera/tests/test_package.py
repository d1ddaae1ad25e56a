"""All that the package brings keeps its contracts."""

from importlib.util import find_spec

import pytest

from bt_manip_contracts import Example, contracts_of

SEEN = "a cube that the camera sees"

WITHOUT = [
    "tree pick_place_seen", "tree stack_blocks_seen", "tree sort_blocks_seen",
    "scene table_seen: goes on from its state",
]  # fmt: skip
"""What needs seen poses: test_seen_poses.py."""

if find_spec("pupil_apriltags") is None:
    WITHOUT.append("DetectTags")

EXAMPLES = {
    "DetectTags": Example(
        {"numbers": "{n}", "poses": "{p}"}, SEEN, fails=({"wanted": "3"}, {"camera": "none"})
    ),
    "EstimatePose": Example(
        {"object": "cube", "pose": "{p}", "position_error": "{e}"}, SEEN,
        fails=({"object": "basket"}, {"object": "nothing"}, {"camera": "none"}),
    ),
    "WaitUntilSeen": Example(
        {"object": "cube", "pose": "{p}", "position_error": "{e}"}, SEEN,
        fails=({"object": "nothing"},),
    ),
    "SeeObjects": Example(
        {"objects": "cube", "seen": "{s}"}, SEEN,
        fails=({"objects": "nothing", "timeout": "0.1"}, {"camera": "none"}),
    ),
    "SegmentTable": Example({"number": "{n}", "poses": "{p}"}, SEEN, fails=({"on": "cube"},)),
    "LookAt": Example({"object": "cube"}, "a cube", fails=({"object": "nothing"},)),
    "IsSeen": Example({"object": "cube"}, SEEN, status="FAILURE"),  # without seen poses
}  # fmt: skip

pytestmark = pytest.mark.usefixtures("opengl")

test_parts_keep_their_contracts = contracts_of("camera", examples=EXAMPLES, without=tuple(WITHOUT))
