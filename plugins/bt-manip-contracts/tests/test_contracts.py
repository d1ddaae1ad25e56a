"""All that comes with bt-manip is held to the contracts that everyone's parts are held to."""

from bt_manip_contracts import Example, contracts_of

from .conftest import AFTER_A_MOTION, AROUND_THE_CUBE, BESIDE_ANOTHER, HOLDING

NEAR_HOME = "0.1;-0.6;0.1;-2.2;0.1;1.6;0.9"
BEYOND = "0;-0.6;0;0.5;0;1.6;0.9"

EXAMPLES = {
    "BackOff": Example({"distance": 0.05}, AFTER_A_MOTION, fails=({"distance": -1.0},)),
    "CloseGripper": Example(fails=({"patience": 0.05}, {"force": 500.0})),
    "Drop": Example({"container": "basket"}, HOLDING, fails=({"patience": 0.01},)),
    "FollowTarget": Example({"object": "cube", "duration": 0.3}, fails=({"height": 2.0},)),
    "Grasp": Example({"object": "cube"}, AROUND_THE_CUBE, fails=({"force": 500.0},)),
    "Hover": Example({"object": "cube", "height": 0.15}, fails=({"height": 2.0},)),
    "IsAt": Example({"pose": "0.4;0;1.3"}, status="FAILURE"),
    "IsIn": Example({"object": "cube", "container": "basket"}, status="FAILURE"),
    "IsOn": Example({"object": "cube", "support": "table"}),
    "IsHolding": Example({"object": "cube"}, HOLDING),
    "Lift": Example({"height": 0.1}, HOLDING, fails=({"height": 2.0}, {"speed": 0.0})),
    "MoveArc": Example(
        {"via": "0.38;-0.05;1.42", "pose": "0.4;-0.1;1.4;0;1;0;0"},
        fails=({"via": "0;0"}, {"pose": "3;0;1"}),
    ),
    "MoveHome": Example(start=HOLDING, fails=({"speed": -1.0},)),
    "MoveLinear": Example({"pose": "0.4;-0.05;1.4;0;1;0;0"}, fails=({"pose": "3;0;1"},)),
    "MoveThrough": Example(
        {"poses": "0.4;-0.05;1.4;0;1;0;0|0.4;-0.05;1.3;0;1;0;0"},
        fails=({"poses": "3;0;1"}, {"blend": -1.0}),
    ),
    "MoveToConfiguration": Example(
        {"configuration": NEAR_HOME}, fails=({"configuration": BEYOND},)
    ),
    "MoveToPose": Example({"pose": "0.35;-0.2;1.3;0;1;0;0"}, fails=({"pose": "3;0;1"},)),
    "ObjectExists": Example({"object": "cube"}),
    "OpenGripper": Example(start=HOLDING, fails=({"patience": 0.01},)),
    "PlaceAt": Example(
        {"object": "cube", "pose": "0.35;-0.15;1.015"}, HOLDING,
        fails=({"pose": "3;0;1"}, {"patience": 0.01}),
    ),
    "PlaceOn": Example({"object": "cube", "support": "other"}, BESIDE_ANOTHER),
    "Reach": Example({"object": "cube"}, fails=({"height": 2.0},)),
    "RemoveObject": Example({"object": "cube"}),
    "SpawnObject": Example({"object": "{object}"}, fails=({"region": "1;0;0;1"},)),
    "WaitUntilAtRest": Example({"object": "cube"}),
    "WaitUntilUndisturbed": Example(),
}  # fmt: skip

test_built_in_parts_keep_their_contracts = contracts_of("builtin", examples=EXAMPLES)
