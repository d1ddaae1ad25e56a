"""The hook that the package declares; its plugin is the example of the README."""

import json
import re
from pathlib import Path

import pytest

from bt_manip import build_station
from bt_manip.bt import Sleep, Tree
from bt_manip.plugins import load_plugins
from bt_manip.runner import Run, RunRequest, TreeSource
from bt_manip_view import Page

README = Path(__file__).resolve().parents[1] / "README.md"


def test_register_panels_shows_a_panel_on_the_page(tmp_path, monkeypatch):
    (code,) = re.findall(r"```python\n(.*?register_panels.*?)```", README.read_text(), re.DOTALL)
    (tmp_path / "of_register_panels.py").write_text(code)
    monkeypatch.setenv("BT_MANIP_PLUGINS_DIR", str(tmp_path))
    parts = load_plugins(warn=pytest.fail).parts
    page = Page({"tool": parts.of("panels").get("tool")}, port=0, speed=None)
    try:
        station = build_station(parts)
        tree = Tree(Sleep(msec=30), clock=station.clock)
        Run(RunRequest(TreeSource("test", "python")), tree, station).execute([page])
        elements = [change[-1] for change in json.loads(page.gui.snapshot()[1])[1:]]
        (number,) = [one for one in elements if one.get("label") == "Height [m]"]
        assert number["value"] == pytest.approx(station.robot.tool_pose.translation[2], abs=1e-3)
    finally:
        page.close()
