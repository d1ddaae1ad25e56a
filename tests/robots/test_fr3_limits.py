"""The FR3's motions keep the limits that its controller checks, position-dependent ones included.

franka-sim needs an environment of its own; ``FRANKA_SIM_PYTHON`` names the Python in it.
"""

import os
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from bt_manip.robots import Robot, read_description
from tests.measuring.random_commands import Motion, RandomCommands

description_files = pytest.importorskip("bt_manip_menagerie").description_files

FR3 = read_description(next(path for path in description_files() if path.stem == "fr3"))
WITHOUT = {
    "margin": {"limit_margin": 0.0},
    "positions": {f"near_{key}": None for key in ("offset", "deceleration", "lower", "upper")},
}
SOME = 3
CHECKER = Path(__file__).with_name("check_with_franka_sim.py")

# libfranka, rate_limiting.h: maximum velocity, offset, 2 deceleration, lower, upper
VENDOR = np.array(
    [
        (2.62, 0.30, 12.0, -2.750100, 2.750100),
        (2.62, 0.20, 5.17, -1.791800, 1.791800),
        (2.62, 0.20, 7.00, -2.906500, 2.906500),
        (2.62, 0.30, 8.00, -3.048100, -0.1458),
        (5.26, 0.35, 34.0, -2.810100, 2.810100),
        (4.18, 0.35, 11.0, 0.54092, 4.520500),
        (5.26, 0.35, 34.0, -3.019600, 3.019600),
    ]
)
TOLERANCE = 1e-3  # [rad/s] subtracted there from the velocity limits


@pytest.fixture(scope="module", autouse=True)
def models(menagerie):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MENAGERIE_ROOT", str(menagerie))
        yield


@cache
def motions(count: int, without: str = "") -> list[Motion]:
    """Return motions of the FR3, of a description without something."""
    commands = RandomCommands(replace(FR3, **WITHOUT.get(without, {})))
    return [commands.motion(seed) for seed in range(count)]


def keeps_the_formula(motion: Motion) -> bool:
    """Tell whether differences of the positions keep the vendor's limits."""
    most, offset, twice, lower, upper = VENDOR.T
    rest = np.repeat(motion.q[:1], 3, axis=0)  # before the motion
    q = np.concatenate([rest, motion.q])
    v, a, jerk = (np.diff(q, n, axis=0)[3 - n :] / 1e-3**n for n in (1, 2, 3))
    q = motion.q
    fastest, slowest = (
        np.clip(np.sqrt(twice * np.maximum(room, 0.0)) - offset, 0.0, most) - TOLERANCE
        for room in (upper - q, q - lower)
    )
    inside = (v <= fastest) & (-v <= slowest) & (np.abs(a) < 10.0) & (np.abs(jerk) < 5000.0)
    return bool(inside.all())


def refused(found: list[Motion], path: Path) -> list[str]:
    """Return the violations that franka-sim finds."""
    python = os.environ.get("FRANKA_SIM_PYTHON")
    if not python:
        pytest.skip("FRANKA_SIM_PYTHON names no Python with franka-sim")
    np.savez(path, **{str(seed): motion.q for seed, motion in enumerate(found)})
    done = subprocess.run(
        [python, "-P", str(CHECKER), str(path)], check=True, capture_output=True, text=True
    )
    count, *lines = done.stdout.splitlines()
    assert int(count) == len(found)
    return lines


def test_motions_keep_the_vendors_formula_and_start_and_end_at_rest():
    found = motions(SOME)
    assert all(map(keeps_the_formula, found))
    for motion in found:
        for row in (0, -1):
            assert not motion.v[row].any() and not motion.a[row].any()


@pytest.mark.parametrize("without", WITHOUT)
def test_motions_without_margin_or_position_dependence_exceed_the_formula(without):
    assert not all(map(keeps_the_formula, motions(2, without)))


def test_the_limits_at_a_position_are_the_vendors_with_the_margin():
    robot = Robot(FR3)
    lower, upper = robot.limits.lower, robot.limits.upper
    for share in np.linspace(0.0, 1.0, 21):
        q = lower + share * (upper - lower)
        most, offset, twice, _, end = VENDOR.T
        vendor = np.minimum(most, np.sqrt(twice * (end - q)) - offset)
        found = robot.limits.velocity_at(q, np.ones(7))
        assert (found <= 0.98 * vendor + 1e-12).all()
        assert (found >= 0.98 * vendor - 0.02).all()  # what a control step changes it by


def test_franka_sim_accepts_motions_and_refuses_them_without_margin_or_position_dependence(
    tmp_path,
):
    assert refused(motions(SOME), tmp_path / "motions.npz") == []
    for without in WITHOUT:
        assert refused(motions(SOME, without), tmp_path / "motions.npz")


@pytest.mark.soak
def test_franka_sim_accepts_100_motions_and_refuses_many_without_either(tmp_path):
    found = motions(100)
    given = {command for motion in found for command in motion.commands}
    assert {"stop", "pause", "scale", "blend", "turn", "servo", "line"} <= given
    assert refused(found, tmp_path / "motions.npz") == []
    for without in WITHOUT:
        assert len(refused(motions(100, without), tmp_path / "motions.npz")) > 30
