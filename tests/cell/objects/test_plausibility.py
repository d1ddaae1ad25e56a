"""Masses and inertias that no body of such a shape has are found, those of bodies are kept."""

from itertools import product

import mujoco
import numpy as np
import pytest
from dm_control import mjcf

from bt_manip.cell.objects import correct_inertias, invented_masses
from tests.support.models import compiled

BODIES = """<mujoco><compiler angle="radian"/>
<asset><mesh name="tip" vertex="0 0 0 .1 0 0 0 .2 0 0 0 .3"/></asset>
<worldbody><body name="base"><joint/><geom size=".3" pos="0 0 2"/>
  <body name="it" pos=".3 .1 -.2" quat=".8 .1 -.3 .5"><joint/>{inertial}
    <geom type="box" size=".05 .1 .15" pos=".1 .02 -.04" quat=".7 .3 .2 -.6"/>
    <geom type="capsule" size=".04 .12" pos="-.05 .1 .06" quat=".3 -.4 .8 .2"/>
    <geom type="mesh" mesh="tip" pos="0 -.1 0" contype="0" conaffinity="0"/>
    <body pos="0 0 .1"><geom type="box" size=".02 .03 .04" pos=".05 -.15 .1"/></body>
  </body></body></worldbody></mujoco>"""
INERTIAL = '<inertial pos=".02 -.03 .01" quat=".9 -.2 .3 .1" mass=".7" diaginertia="{} {} {}"/>'
MASS = 0.7  # [kg]
SOLID = BODIES.format(inertial="").replace("contype", 'density="0" contype')  # what collides


def corrected(text):
    """Give the body after the correction, and the warnings."""
    root = mjcf.from_xml_string(text)
    warnings = list(correct_inertias(root, compiled(root)))
    return compiled(root).body("it"), warnings


@pytest.fixture(scope="module")
def reach():
    """Give the largest distance of a corner of a geom's box from the centre on each axis [m]."""
    model = compiled(mjcf.from_xml_string(BODIES.format(inertial=INERTIAL.format(1, 1, 1))))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    body = model.body("it").id
    corners = [
        data.geom_xpos[geom] + data.geom_xmat[geom].reshape(3, 3) @ (box[:3] + signs * box[3:])
        for geom, box in enumerate(model.geom_aabb)
        for signs in product((-1, 1), repeat=3)
        if model.geom_bodyid[geom] >= body
    ]
    return np.abs((corners - data.xipos[body]) @ data.ximat[body].reshape(3, 3)).max(axis=0)


@pytest.mark.parametrize("axis", range(3))
def test_an_inertia_is_kept_while_its_mass_fits_between_the_ends_of_its_shape(axis, reach):
    """Half of the mass is at each end on one axis, and further in on the others."""
    shape = compiled(mjcf.from_xml_string(SOLID)).body("it")
    for share, kept in ((1.0, True), (1.02, False)):
        squares = MASS * reach**2 * np.roll([share, 0.3**2, 0.2**2], axis)
        given = squares.sum() - squares  # moments about each axis
        body, warnings = corrected(BODIES.format(inertial=INERTIAL.format(*given)))
        assert body.mass == pytest.approx(MASS) and bool(warnings) is not kept
        if kept:
            assert body.inertia == pytest.approx(given)
        else:
            assert body.inertia == pytest.approx(shape.inertia * MASS / shape.mass)
            assert body.iquat == pytest.approx(shape.iquat)
            (text,) = warnings
            assert f"'it': an inertia of {given.max():.3g} kg m2 is impossible for 0.7 kg" in text
            assert f"within {np.linalg.norm(reach):.3g} m" in text


@pytest.mark.parametrize(("share", "told"), [(0.0098, True), (0.0102, False)])
def test_an_inertia_below_a_hundredth_of_that_of_its_shape_is_told_and_kept(share, told):
    shape = compiled(mjcf.from_xml_string(SOLID)).body("it")
    given = [share * shape.inertia.max() * MASS / shape.mass[0]] * 3
    body, warnings = corrected(BODIES.format(inertial=INERTIAL.format(*given)))
    assert body.inertia == pytest.approx(given)
    assert ["below a hundredth" in text for text in warnings] == [True] * told


@pytest.mark.parametrize(
    ("mass", "moment", "geom"), [(0.1, 1.0, ""), (4.2e-6, 1.7e-12, '<geom size="1e-3"/>')]
)
def test_an_inertia_without_a_shape_or_of_a_grain_is_kept(mass, moment, geom):
    body, warnings = corrected(
        f"""<mujoco><worldbody><body name="it"><inertial pos="0 0 0" mass="{mass}"
        diaginertia="{moment} {moment} {moment}"/>{geom}</body></worldbody></mujoco>"""
    )
    assert warnings == [] and body.inertia == pytest.approx([moment] * 3)


def test_masses_that_the_file_does_not_give_and_that_are_a_hundredth_of_all_are_listed():
    """Masses follow from 1000 kg/m3; a hundredth of all is 1.07 kg."""

    def box(mass):
        return f'<geom type="box" size="{" ".join(3 * [repr(0.5 * (mass / 1000) ** (1 / 3))])}"/>'

    shapes = {
        "weighed": '<geom size=".1" mass="2"/>', "dense": '<geom size=".1" density="500"/>',
        "inertial": '<inertial pos="0 0 0" mass="96" diaginertia="1 1 1"/>' + box(3.0),
        "light": box(1.04), "bare": box(1.1),
    }  # fmt: skip
    moving = "".join(f'<body name="{n}"><joint/>{shape}</body>' for n, shape in shapes.items())
    text = f'<mujoco><worldbody><body name="base">{box(5.0)}{moving}</body></worldbody></mujoco>'
    root = mjcf.from_xml_string(text)
    assert compiled(root).body_mass.sum() == pytest.approx(107.2, abs=0.1)
    for fixed, listed in ((True, "'bare' 1.1 kg"), (False, "'base' 5 kg, 'bare' 1.1 kg")):
        warning = invented_masses(root, compiled(root), fixed=fixed)
        assert warning.endswith(f"at 1000 kg/m3 (water): {listed}")
