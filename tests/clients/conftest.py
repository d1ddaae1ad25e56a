"""Programs that others wrote, with bt-manip's environments and files: `make test-clients`."""

import os
import sys
from types import ModuleType

import pytest

os.environ.setdefault("MUJOCO_GL", "disable")
collect_ignore: list[str] = []

try:
    import torch

    torch.set_num_threads(1)
except ImportError:  # as in the environment of the other tests
    collect_ignore += ["test_stable_baselines.py", "test_robomimic.py"]
else:
    # robomimic imports torchvision for its image networks. The wheel's operators are built for
    # another build of torch, which refuses to declare them; the Python part works without.
    sys.modules["torchvision._meta_registrations"] = ModuleType("_meta_registrations")


@pytest.fixture(scope="session", autouse=True)
def _registered():
    import bt_manip_learn.envs  # noqa: F401 (registers the environments)
