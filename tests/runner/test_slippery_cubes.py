"""Cubes are placed from the friction on that carries their weight, and refused below it."""

import pytest

from .conftest import report_of

CUBE = """<mujoco>
  <worldbody><body name="cube">
    <geom type="box" size="0.025 0.025 0.025" mass="{}" friction="{}" solref="0.004 1"/>
  </body></worldbody>
</mujoco>"""


def place(parts, tmp_path, mass, friction):
    """Run a cycle with a cube of a mass [kg] and a friction."""
    path = tmp_path / "cube.xml"
    path.write_text(CUBE.format(mass, friction))
    (cycle,) = report_of(parts, "pick_place", settings={"cube": str(path)}).cycles
    assert bool(cycle.placed) is (cycle.status == "SUCCESS")
    return cycle


MORE = [(0.057, 0.05), (0.057, 1.0), (1.0, 1.0)]


@pytest.mark.parametrize(
    ("mass", "friction"),
    [(1.0, 0.15), *(pytest.param(*one, marks=pytest.mark.soak) for one in MORE)],  # of 0.0981
)
def test_a_cube_with_enough_friction_is_placed(parts, tmp_path, mass, friction):
    assert place(parts, tmp_path, mass, friction).status == "SUCCESS"


def test_a_cube_that_would_slip_fails_with_the_friction_that_it_needs(parts, tmp_path):
    cycle = place(parts, tmp_path, 0.057, 0.003)
    assert cycle.status == "FAILURE"
    assert "a friction coefficient of at least 0.00559 at 2 x 50 N" in cycle.reason
    assert "has 0.003" in cycle.reason
