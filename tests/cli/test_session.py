"""A view that controls runs starts others after the first one, in the same session."""

import pytest

PLUGIN = '''
from bt_manip import hookimpl
from bt_manip.runner import RunView


class Again(RunView):
    def __init__(self, session):
        self.tell, self.paces = session.tell, session.stays

    def run_started(self, run):
        self.tell(f"{run.request.tree.name} at {run.request.real_time}, stays {self.paces}")

    def serve(self, session):
        first = session.station
        self.tell(f"same cell: {session.has_station_of(session.request(cycles=2))}")
        for in_place in (True, False):
            code = session.run(in_place=in_place, seed=4 if in_place else 5)
            report = session.last.report
            kept = session.station is first
            self.tell(f"seed {report.seed}: {report.status}, code {code}, kept {kept}")

    def close(self):
        self.tell("closed")


def again(session):
    """Run the tree again."""
    return Again(session)


again.controls_runs = True


def once(session):
    """Watch a run."""
    return Again(session)


@hookimpl
def register_views(register):
    register("again", again)
    register("once", once)
'''


@pytest.fixture
def plugins(tmp_path):
    folder = tmp_path / "plugins"
    folder.mkdir()
    (folder / "views.py").write_text(PLUGIN)
    return folder


def test_runs_follow_the_first_one_in_the_cell_as_it_is_or_in_a_new_one(
    bt_manip, trees, plugins, tmp_path
):
    report = tmp_path / "report.json"
    options = ("--again", "--plugins-dir", plugins, "--seed", 3, "--report", report)
    code, out, _ = bt_manip("run", f"{trees}:quick", *options)
    assert code == 0
    assert '"seed": 3' in report.read_text()  # files are those of the first run
    lines = out.splitlines()
    assert out.count("at None, stays True") == 3
    assert "same cell: True" in lines
    assert "seed 4: SUCCESS, code 0, kept True" in lines
    assert "seed 5: SUCCESS, code 0, kept False" in lines
    assert out.rstrip().endswith("closed")


def test_the_exit_code_is_that_of_the_first_run(bt_manip, trees, plugins):
    done = bt_manip("run", f"{trees}:failing", "--again", "--plugins-dir", plugins)
    assert done.code == 1 and "seed 5: FAILURE, code 1" in done.out


def test_a_view_that_controls_no_runs_ends_with_the_run(bt_manip, trees, plugins):
    done = bt_manip("run", f"{trees}:quick", "--once", "--plugins-dir", plugins)
    assert done.code == 0
    assert done.out.count("at 1.0, stays False") == 1
    assert "same cell" not in done.out and "closed" not in done.out
