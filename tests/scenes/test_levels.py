"""Levels say how strongly a scene varies, by name."""

import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.exceptions import BtManipError
from bt_manip.runner import request_of, with_varied
from bt_manip.scenes import Level, levels_of, read_scene, table_and_basket, with_level

SCENE = """
[[robots]]
position = [-0.1, 0.0, 1.015]
[[objects]]
model = "table"
[[objects]]
model = "can"
on = "table"
position = [0.3, 0.0]
[[cameras]]
name = "side"
position = [0.5, -1.2, 1.6]
looking_at = [0.4, 0.0, 1.0]

[randomization.objects.can]
position = { plus = { uniform = [[-0.1, 0.0, 0.0], [0.1, 0.0, 0.0]] } }
mass = { uniform = [0.1, 0.3] }

[levels.pose.2]
settings = { region = "0;1;0;1", attempts = 2 }
objects.can.yaw = { normal = [0.0, 0.1] }
"""


@pytest.fixture
def scene(write, parts):
    return read_scene(write(SCENE), parts)


def quantities(scene):
    found = scene.randomization.objects.items()
    return {(name, key) for name, lines in found for key in lines}


def test_level_0_takes_variations_of_a_name_away_and_others_replace_them_and_set_keys(scene):
    fixed, settings = with_level(scene, "pose", 0)
    assert (quantities(fixed), settings) == ({("can", "mass")}, {})
    same, _ = with_level(scene, "pose", 1)
    assert same.randomization == scene.randomization
    wide, settings = with_level(scene, "pose", 2)
    assert quantities(wide) == {("can", "yaw"), ("can", "mass")}
    assert settings == {"region": "0;1;0;1", "attempts": "2"}
    assert str(levels_of(scene)["pose"][2]) == "can yaw -0.6 to 0.6; region=0;1;0;1; attempts=2"


def test_every_scene_has_levels_of_mass_friction_light_and_camera(scene):
    known = levels_of(scene)
    assert {name: [*known[name]] for name in ("friction", "light", "camera")} == dict.fromkeys(
        ("friction", "light", "camera"), [0, 1, 2]
    )
    assert str(known["mass"][1]) == "can mass 0.1 to 0.3"  # its own
    assert str(known["mass"][2]) == "* mass times 0.5 to 2"
    assert str(known["camera"][1]).count("side position plus -0.01 to 0.01") == 1


def test_what_is_drawn_at_a_level_is_within_its_bounds_and_leaves_fixed_objects_as_they_are(
    scene, parts
):
    for name in ("mass", "friction", "light", "camera"):
        scene, _ = with_level(scene, name, 2)
    station = build_station(parts, scene=scene, seed=3)
    masses = []
    for cycle in range(12):
        station.randomizer.begin(cycle)
        sampled = station.randomizer.sampled
        assert "table" not in sampled["objects"]
        assert {*sampled["cameras"]} == {"overview", "side"}
        masses.append(sampled["objects"]["can"]["mass"])
    assert min(masses) >= 0.1 and max(masses) <= 0.4 and np.ptp(masses) > 0.1


@pytest.mark.parametrize(
    ("name", "level", "message"),
    [
        ("masss", 1, "no levels of 'masss'; did you mean 'mass'?"),
        ("pose", 3, "has the levels 0, 1, 2 of pose, got 3"),
        ("mass", "strong", "has the levels 0, 1, 2 of mass, got strong"),
    ],
)
def test_a_level_that_the_scene_has_not_is_refused(scene, name, level, message):
    with pytest.raises(BtManipError, match=message):
        with_level(scene, name, level)


def test_a_level_that_is_no_number_is_refused_with_its_key(write, parts):
    wide = '[levels.pose.wide]\nsettings = { region = "0;1;0;1" }\n'
    with pytest.raises(BtManipError, match="levels.pose.wide.* no level"):
        read_scene(write(SCENE + wide), parts)


def test_a_level_is_a_parameter_and_given_settings_are_kept(parts):
    varied = {"scene.pose": 2, "scene.size": 1}
    wide, _ = with_varied(request_of("pick_place", parts, varied=varied), parts)
    assert wide.settings["region"] == "0.2;0.5;-0.4;0.4"
    assert quantities(wide.scene) == {("cube", "size")}
    settings = {"region": "0.3;0.3;0;0"}
    given = request_of("pick_place", parts, settings=settings, varied={"scene.pose": 2})
    assert with_varied(given, parts)[0].settings == settings
    assert not table_and_basket().randomization and str(Level()) == "-"
    known = levels_of(table_and_basket())
    assert [str(known["size"][n]) for n in (1, 2)] == [
        "cube size 0.045 to 0.055", "cube size 0.03 to 0.06"
    ]  # fmt: skip
    assert str(known["colour"][1]) == "cube colour 0.1 to 0.9"
