"""Cubes are placed from the friction on that carries their weight, and refused below it."""

from pathlib import Path

import numpy as np
import pytest

from .conftest import report_of

SCENES = Path(__file__).parents[2] / "scenes"
WEIGHT = 0.0565 * 9.81  # [N] of the bundled cube
FORCE = 50.0  # [N] of each finger in pick_place
CUBE = """<mujoco>
  <worldbody><body name="cube">
    <geom type="box" size="0.025 0.025 0.025" mass="{}" friction="{}" solref="0.004 1"/>
  </body></worldbody>
</mujoco>"""


@pytest.fixture
def place(parts, tmp_path):
    """Return a function that runs a cycle with a cube of a mass [kg] and a friction."""

    def go(mass, friction):
        path = tmp_path / "cube.xml"
        path.write_text(CUBE.format(mass, friction))
        (cycle,) = report_of(parts, "pick_place", settings={"cube": str(path)}).cycles
        assert bool(cycle.placed) is (cycle.status == "SUCCESS")
        return cycle

    return go


def test_a_cube_with_enough_friction_is_placed(place):
    assert place(1.0, 0.2).status == "SUCCESS"


@pytest.mark.soak
@pytest.mark.parametrize(("mass", "friction"), [(0.057, 0.05), (0.057, 1.0), (1.0, 1.0)])
def test_cubes_with_more_friction_are_placed(place, mass, friction):
    assert place(mass, friction).status == "SUCCESS"


def test_a_cube_that_would_slip_fails_with_the_friction_that_it_needs(place):
    cycle = place(0.057, 0.003)
    assert cycle.status == "FAILURE"
    assert "a friction coefficient of at least 0.00559 at 2 x 50 N" in cycle.reason
    assert "has 0.003" in cycle.reason


def best_threshold(x: np.ndarray, success: np.ndarray) -> tuple[float, int]:
    """Return the threshold that splits successes from failures best, and its exceptions."""
    x, success = x[np.argsort(x)], success[np.argsort(x)]
    wrong = [int(success[:k].sum() + (~success[k:]).sum()) for k in range(len(x) + 1)]
    k = int(np.argmin(wrong))
    return float(np.sqrt(x[max(k - 1, 0)] * x[min(k, len(x) - 1)])), wrong[k]


@pytest.mark.soak
def test_success_begins_at_the_friction_that_carries_the_weight(parts, tmp_path):
    values = np.geomspace(0.002, 0.2, 2000).round(6).tolist()
    scene = (SCENES / "varied_pick.toml").read_text(encoding="utf-8").partition("[randomization")[0]
    path = tmp_path / "slippery.toml"
    path.write_text(f"{scene}[randomization.objects.cube]\nfriction = {{ choice = {values} }}\n")
    cycles = report_of(parts, "pick_place", scene=str(path), cycles=100).cycles
    friction = np.array([c.randomized["objects"]["cube"]["friction"] for c in cycles])
    success = np.array([c.status == "SUCCESS" for c in cycles])
    assert (success == [bool(c.placed) for c in cycles]).all()
    threshold, wrong = best_threshold(friction, success)
    needed = WEIGHT / (2.0 * FORCE)
    assert wrong <= 3
    assert 0.7 * needed <= threshold <= 1.3 * needed
    for cycle in np.array(cycles)[friction < needed]:
        assert "too little friction to hold 'cube'" in cycle.reason
