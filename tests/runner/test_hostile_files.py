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
    for _ in range(rng.randint(1, 4)):
        found = list(re.finditer(r"-?[0-9][0-9.e-]*|\"[^\"\n]*\"|\[[^][\n]*\]|[a-z_]+", text))
        if rng.random() < 0.7 and found:
            start, end = rng.choice(found).span()
        else:
            start = rng.randrange(len(text) + 1)
            end = start + rng.randrange(20)
        text = text[:start] + rng.choice(PIECES) + text[end:]
    return text


def check(read, error=BtManipError) -> bool:
    """Return whether a file was refused; any other exception and a long time are failures."""
    start = time.process_time()
    try:
        read()
        refused = False
    except error as problem:
        refused = True
        assert str(problem) and len(max(str(problem).splitlines(), key=len)) < 3000
    assert time.process_time() - start < 20.0  # a hang, not a measurement
    return refused


def check_scenes(parts, folder: Path, count: int, *, built: bool) -> None:
    text = (bundled_root("scenes") / "varied_pick.toml").read_text()
    rng, path = random.Random(1), folder / "scene.toml"
    refused = 0
    for _ in range(count):
        path.write_text(damaged(text, rng))

        def read():
            scene = read_scene(path, parts)
            if built:
                build_station(parts, scene=scene).randomizer.begin(0)

        refused += check(read)
    assert refused > count / 4


def check_robots(folder: Path, count: int, name: str, least: int) -> None:
    """Damage a file of a robot; at least one time in ``least`` it must be refused."""
    models = Path(__file__).parent.parent / "robots" / "models"
    texts = {one: (models / one).read_text() for one in ("post.toml", "post.xml", "pincers.xml")}
    for one, text in texts.items():
        (folder / one).write_text(text)
    rng, path = random.Random(2), folder / name

    def read():
        path.write_text(damaged(texts[name], rng))
        Robot(read_description(folder / "post.toml"))

    assert sum(check(read) for _ in range(count)) > count / least


def check_snapshots(folder: Path, count: int) -> None:
    path = folder / "snapshot.json"
    save_snapshot(path, {"a": [1.0, {"b": "text"}], "c": None})
    text, rng = path.read_text(), random.Random(4)
    for _ in range(count):
        path.write_text(changed := damaged(text, rng))
        try:
            same = json.loads(changed) == json.loads(text)
        except (ValueError, RecursionError):
            same = False
        assert check(lambda: load_snapshot(path)) or same


def test_damaged_scenes_are_refused_or_read(parts, tmp_path):
    check_scenes(parts, tmp_path, 40, built=False)


@pytest.mark.parametrize(("name", "count", "least"), [("post.toml", 25, 4), ("post.xml", 20, 8)])
def test_damaged_robots_are_refused_or_made(tmp_path, name, count, least):
    check_robots(tmp_path, count, name, least)


def test_damaged_snapshots_are_refused(tmp_path):
    check_snapshots(tmp_path, 100)


@pytest.mark.soak
def test_thousands_of_damaged_files_are_refused_or_read(parts, tmp_path):
    check_scenes(parts, tmp_path, 2000, built=True)
    check_robots(tmp_path, 3000, "post.toml", 4)
    check_robots(tmp_path, 2000, "post.xml", 8)
    check_snapshots(tmp_path, 10_000)
