"""Scenes, robots, models and snapshots damaged at random are errors, never a crash or a hang."""

import json
import random
import re
import time
from pathlib import Path

import pytest

from bt_manip import build_station
from bt_manip.exceptions import BtManipError
from bt_manip.models import bundled_root
from bt_manip.robots import Robot, read_description
from bt_manip.runner import load_snapshot, save_snapshot
from bt_manip.scenes.scene_file import read_scene

PIECES = (
    "nan", "inf", "-1", "0", "1e300", "-1e-300", "9" * 400, "true", "''", '"x"', "[]", "{}", "[[",
    "]]", "{", "}", "=", ".", "\n", "#", '"""', "'''", "\\", "\0", "\x7f", "é", "[1, 2]", "[nan]",
    "{ uniform = [-1, 1] }", "{ choice = [] }", "[[objects]]\n", "[robots]\n", "1979-05-27",
    '"/dev/zero"', '"fuel:a/b"', '"../x"', '"a\\u0000b"', "a.b.c = 1\n",
)  # fmt: skip
VALUES = (None, "x", -1, 0, 1e300, float("inf"), 10**400, [], {}, [[]], True, "fuel:a/b")


def damaged(text: str, rng: random.Random) -> str:
    """Replace some values, cut some pieces out and put others in."""
    for _ in range(rng.randint(1, 4)):
        found = list(re.finditer(r"-?[0-9][0-9.e-]*|\"[^\"\n]*\"|\[[^][\n]*\]|[a-z_]+", text))
        if rng.random() < 0.7 and found:
            start, end = rng.choice(found).span()
        else:
            start = rng.randrange(len(text) + 1)
            end = start + rng.randrange(20)
        text = text[:start] + rng.choice(PIECES) + text[end:]
    return text


def check(read) -> bool:
    """Return whether a file was refused; any other exception and a long time are failures."""
    start = time.process_time()
    try:
        read()
        refused = False
    except BtManipError as problem:
        refused = True
        assert str(problem) and len(max(str(problem).splitlines(), key=len)) < 3000
    assert time.process_time() - start < 20.0  # a hang, not a measurement
    return refused


def soak(*values):
    return pytest.param(*values, marks=pytest.mark.soak)


@pytest.mark.parametrize(("count", "built"), [(40, False), soak(2000, True)])
def test_damaged_scenes_are_refused_or_read(parts, tmp_path, count, built):
    text = (bundled_root("scenes") / "varied_pick.toml").read_text()
    rng, path = random.Random(1), tmp_path / "scene.toml"

    def read():
        path.write_text(damaged(text, rng))
        scene = read_scene(path, parts)
        if built:
            build_station(parts, scene=scene).randomizer.begin(0)

    assert sum(check(read) for _ in range(count)) > count / 4


@pytest.mark.parametrize(
    ("name", "count", "least"),  # one time in `least` it must be refused
    [
        ("post.toml", 25, 4),
        ("post.xml", 20, 8),
        soak("post.toml", 3000, 4),
        soak("post.xml", 2000, 8),
    ],
)
def test_damaged_robots_are_refused_or_made(tmp_path, name, count, least):
    models = Path(__file__).parent.parent / "robots" / "models"
    texts = {one: (models / one).read_text() for one in ("post.toml", "post.xml", "pincers.xml")}
    for one, text in texts.items():
        (tmp_path / one).write_text(text)
    rng = random.Random(2)

    def read():
        (tmp_path / name).write_text(damaged(texts[name], rng))
        Robot(read_description(tmp_path / "post.toml"))

    assert sum(check(read) for _ in range(count)) > count / least


@pytest.mark.parametrize("count", [100, soak(10_000)])
def test_damaged_snapshots_are_refused(tmp_path, count):
    path = tmp_path / "snapshot.json"
    save_snapshot(path, {"a": [1.0, {"b": "text"}], "c": None})
    text, rng = path.read_text(), random.Random(4)
    for _ in range(count):
        path.write_text(changed := damaged(text, rng))
        try:
            same = json.loads(changed) == json.loads(text)
        except (ValueError, RecursionError):
            same = False
        assert check(lambda: load_snapshot(path)) or same
