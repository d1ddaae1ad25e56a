"""Panels of plugins are isolated: one that raises costs a warning, page and run go on."""

import json
from importlib.metadata import EntryPoint

import pytest

from bt_manip import build_station
from bt_manip.bt import Sleep, Tree
from bt_manip.plugins import load_plugins
from bt_manip.runner import Run, RunRequest, TreeSource
from bt_manip_view import Page
from bt_manip_view.page.plugin_panels import page_panels

VIEW = [EntryPoint("view", "bt_manip_view.plugin", "bt_manip")]
"""The entry point of this package."""

PLUGIN = """
from bt_manip import hookimpl
from bt_manip_view import Panel

class Broken(Panel):
    {}

@hookimpl
def register_panels(register):
    register("broken", Broken)
"""


@pytest.fixture
def watched_run(tmp_path, capsys, monkeypatch):
    """Execute a run with a plugin's panel of this body; return kinds of elements, and warnings."""

    def run(body: str):
        (tmp_path / "bad_panel.py").write_text(PLUGIN.format(body))
        monkeypatch.setenv("BT_MANIP_PLUGINS_DIR", str(tmp_path))
        plugins = load_plugins(entry_points=VIEW, warn=pytest.fail)
        page = Page(page_panels(plugins), port=0, speed=None)
        try:
            station = build_station(plugins.parts)
            tree = Tree(Sleep(msec=50), clock=station.clock)
            Run(RunRequest(TreeSource("test", "python")), tree, station).execute([page])
        finally:
            page.close()
        assert station.cell.time == pytest.approx(0.06)
        kinds = {change[3] for change in json.loads(page.gui.snapshot()[1])[1:]}
        return kinds, capsys.readouterr().err.splitlines()

    return run


@pytest.mark.parametrize("method", ["start", "handle", "end_tick", "draw", "close"])
def test_a_panel_that_raises_is_not_called_again(watched_run, method):
    _, (warning,) = watched_run(f"def {method}(self, *rest): raise ValueError('too hot')")
    assert warning.startswith("Warning: panel 'broken' of plugin 'bad_panel'")
    assert "is not called again, the run continues: ValueError: too hot" in warning


def test_a_panel_that_cannot_be_made_is_left_out(watched_run):
    kinds, (warning,) = watched_run("def __init__(self, page): raise ValueError('too hot')")
    assert "is left out: panel 'broken' cannot be made: ValueError: too hot" in warning
    assert kinds >= {"tree", "timeline", "log", "blackboard", "plot"}
