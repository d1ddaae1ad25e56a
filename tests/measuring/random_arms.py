"""Small arms with random joints, links and limits."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from bt_manip.robots import Robot, RobotDescription, compile_alone

EFFORT = 500.0  # [N m] or [N]: more than the heaviest of them needs


def random_arm(seed: int, **fields: float | None) -> Robot:
    """Return an arm of 2 to 7 joints, of which some slide, compiled alone."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 8))
    acceleration = rng.uniform(2.0, 20.0, n)
    bodies = "".join(_link(rng, i) for i in range(n))
    model = (
        f'<mujoco><compiler angle="radian" autolimits="true"/><worldbody>{bodies}'
        f'<site name="tool" pos="{_numbers(rng.uniform(0.05, 0.2, 3))}"/>'
        f"{'</body>' * n}</worldbody></mujoco>"
    )
    with TemporaryDirectory() as folder:
        path = Path(folder) / "arm.xml"
        path.write_text(model)
        robot = Robot(
            RobotDescription(
                name="random",
                model=str(path),
                arm_joints=tuple(f"joint{i}" for i in range(n)),
                tool_frame="tool",
                home=(0.0,) * n,
                velocity=tuple(rng.uniform(0.3, 4.0, n)),
                acceleration=tuple(acceleration),
                jerk=tuple(acceleration * rng.uniform(20.0, 300.0, n)),
                effort=(EFFORT,) * n,
                **fields,
            )
        )
        compile_alone(robot)
    return robot


def _link(rng: np.random.Generator, number: int) -> str:
    """Return the beginning of a body with a joint and a link."""
    slides = rng.random() < 0.15
    low, high = rng.uniform(-3.0, -0.5), rng.uniform(0.5, 3.0)
    share = 0.2 if slides else 1.0  # [m]
    end = rng.uniform(-0.2, 0.2, 3) + (0.0, 0.0, 0.15)
    start = np.zeros(3) if number == 0 else rng.uniform(0.0, 0.2, 3)
    return (
        f'<body pos="{_numbers(start)}"><joint name="joint{number}" '
        f'type="{"slide" if slides else "hinge"}" axis="{_numbers(rng.normal(size=3))}" '
        f'range="{share * low:.3f} {share * high:.3f}" armature="0.05" damping="0.1"/>'
        f'<geom type="capsule" size="0.02" fromto="0 0 0 {_numbers(end)}" density="500"/>'
    )


def _numbers(values: np.ndarray) -> str:
    return " ".join(f"{value:.4f}" for value in values)
