"""What a test session gets from the package being installed."""

import subprocess
import sys
import textwrap

import pytest

import bt_manip_contracts.contract_list  # noqa: F401  what the inner sessions import goes with them

pytest_plugins = ("pytester",)

IMPORT = "from bt_manip_contracts import Example, contracts_of\n"
HEAVY = ("mujoco", "pinocchio", "dm_control", "numpy", "rich", "lxml", "py_trees", "click")


@pytest.fixture
def session(situations, pytester):
    """Run pytest over a file and give its result."""
    situations.reset()  # whatever has to be imported is: it would be imported anew by each session

    def run(*options: str, test_it: str = ""):
        if test_it:
            (pytester.path / "test_it.py").write_text(test_it)
        return pytester.runpytest_inprocess("-p", "no:cacheprovider", *options)

    return run


def test_a_session_that_asks_for_no_contracts_loads_nothing_heavy(tmp_path):
    (tmp_path / "test_it.py").write_text(
        f"import sys\ndef test_it():\n    assert not {set(HEAVY)!r} & set(sys.modules)\n"
    )
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path)]
    plain = ["-p", "no:hypothesispytest", "-p", "no:anyio"]  # what others load is their affair
    done = subprocess.run([*command, *plain], capture_output=True, text=True, cwd=tmp_path)
    assert "1 passed" in done.stdout, done.stdout


MINE = """
    from bt_manip import hookimpl
    from bt_manip.bt import Condition, Input, Status

    class Looks(Condition):
        \"\"\"Look.\"\"\"
        object = Input(str, doc="Name.")

        def setup(self, **infrastructure):
            self.cell = infrastructure["cell"]

        def update(self):
            return Status.SUCCESS if self.object in self.cell.objects else self.fail("not there")

    @hookimpl
    def register_behaviours(register):
        register(Looks)
    """


def test_one_line_holds_a_plugin_to_its_contracts(session, monkeypatch, pytester):
    (pytester.path / "plugins").mkdir()
    mine = pytester.path / "plugins" / "mine.py"
    mine.write_text(textwrap.dedent(MINE))
    monkeypatch.setenv("BT_MANIP_PLUGINS_DIR", str(mine.parent))
    line = (
        IMPORT + 'test_mine = contracts_of("mine", examples={"Looks": Example({"object": "cube"})})'
    )
    session(test_it=line).assert_outcomes(passed=9)
    result = session(test_it=IMPORT + 'test_mine = contracts_of("mine")')
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*examples={'Looks': Example({\"object\": ...})}*"])
    result = session(test_it=IMPORT + 'test_it = contracts_of("mnie")')
    result.stdout.fnmatch_lines(["*no plugin 'mnie'; did you mean 'mine'*"])


RUNS = """
    from pathlib import Path

    from bt_manip import hookimpl
    from bt_manip.scenes import table_and_basket
    from bt_manip.testing import Check

    @hookimpl
    def register_contracts(register):
        register("mine", check_trees)

    def check_trees(parts, provides, settings):
        for name in provides["trees"]:
            yield Check(f"tree {name}: has a name", lambda situations: None)

    @hookimpl
    def register_scenes(register):
        register("place", table_and_basket)

    @hookimpl
    def register_trees(register):
        register("rest", Path(__file__).with_name("rest.xml"), scene="place")
    """


def test_one_line_holds_trees_and_scenes_of_a_plugin_to_contracts_of_all_plugins(
    session, monkeypatch, pytester
):
    folder = pytester.path / "plugins"
    folder.mkdir()
    (folder / "runs.py").write_text(textwrap.dedent(RUNS))
    leaf = '<root BTCPP_format="4"><BehaviorTree ID="T"><Sleep msec="200"/></BehaviorTree></root>'
    (folder / "rest.xml").write_text(leaf)
    monkeypatch.setenv("BT_MANIP_PLUGINS_DIR", str(folder))
    line = IMPORT + 'test_runs = contracts_of("runs")'
    session("-k", "tree", test_it=line).assert_outcomes(passed=2, deselected=1)
    result = session("--collect-only", "-q", "-m", "soak or not soak")
    result.stdout.fnmatch_lines_random(
        [
            "*scene place: goes on from its state at any time?",
            "*tree rest: has the same episodes in any process?",
            "*tree rest: has a name?",
        ]
    )
