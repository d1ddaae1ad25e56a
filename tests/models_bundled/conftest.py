"""What the tests of the bundled models share."""

from collections.abc import Callable
from pathlib import Path

import mujoco
import pytest
from dm_control import mjcf

MODELS = Path(__file__).parents[2] / "models"


@pytest.fixture(scope="module")
def panda() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(MODELS / "panda" / "panda.xml"))


@pytest.fixture
def scene() -> Callable[..., mjcf.Physics]:
    """Compile models by name into one world, as in `scene(table=(0, 0, 0))`; cubes move freely."""

    def build(
        free: tuple[str, ...] = ("cube",), **positions: tuple[float, float, float]
    ) -> mjcf.Physics:
        root = mjcf.RootElement(model="world")
        root.compiler.angle = "radian"
        root.option.set_attributes(timestep=0.001, cone="elliptic", impratio=10)
        for name, position in positions.items():
            frame = root.attach(mjcf.from_path(str(MODELS / name / f"{name}.xml")))
            frame.pos = position
            if name in free:
                frame.add("freejoint")
        return mjcf.Physics.from_mjcf_model(root)

    return build
