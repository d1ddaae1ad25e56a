"""The page about scenes shows a valid file and lists every quantity and variation."""

import re
from pathlib import Path

from bt_manip import build_station
from bt_manip.cell.physics.model_properties import CAMERA, LIGHT, PROPERTIES
from bt_manip.cell.randomization import Randomization, parse_variation
from bt_manip.cell.randomization.variations import PARSERS
from bt_manip.scenes.scene_file import read_scene

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "scenes.md").read_text()


def test_the_file_of_the_page_is_a_scene(tmp_path, parts):
    path = tmp_path / "page.toml"
    path.write_text(re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)[0])
    station = build_station(parts, scene=read_scene(path, parts))
    station.randomizer.begin(0)
    assert station.randomizer.sampled["objects"]["drink"].keys() == {"mass"}
    assert {"drink", "cube", "side"} < station.cell.entities.keys()


def test_every_quantity_and_variation_is_on_the_page():
    for kind in (LIGHT, CAMERA):
        row = next(line for line in PAGE.splitlines() if line.startswith(f"| `{kind}s` |"))
        assert set(PROPERTIES[kind]) <= set(re.findall(r"`(\w+)`", row))
    for way in PARSERS:
        assert f"{way} = " in PAGE
    assert parse_variation({"uniform": [0, 1]})
    for kind in Randomization.__dataclass_fields__:
        assert f"| `{kind}` |" in PAGE
