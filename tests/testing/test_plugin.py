"""What somebody's own test session gets from bt-manip being installed."""

import textwrap

import pytest

import bt_manip.plugins
import bt_manip.testing.tree_reading  # noqa: F401  what the inner sessions import goes with them
from tests.support.program import run_python

pytest_plugins = ("pytester",)

HEAVY = ("mujoco", "pinocchio", "dm_control", "numpy", "rich", "lxml", "py_trees", "click")

PICK = """<root BTCPP_format="4"><BehaviorTree ID="Pick">
  <Fallback>
    <Inverter><ObjectExists name="nothing there" object="cube"/></Inverter>
    <Sequence><Grasp object="cube"/><Lift height="0.05"/></Sequence>
    <MoveHome/>
  </Fallback>
</BehaviorTree></root>"""


@pytest.fixture
def session(situations, pytester):
    situations.reset()  # whatever has to be imported is: it would be imported anew by each session

    def run(*options: str, files: dict[str, str] | None = None, **modules: str):
        for name, source in modules.items():
            path = pytester.path / f"{name}.py"
            path.write_text(textwrap.dedent(source))
        for name, text in (files or {}).items():
            (pytester.path / name).write_text(text)
        return pytester.runpytest_inprocess("-p", "no:cacheprovider", *options)

    return run


def test_a_session_that_asks_for_nothing_loads_nothing_heavy(tmp_path):
    (tmp_path / "test_it.py").write_text(
        f"import sys\ndef test_it():\n    assert not {set(HEAVY)!r} & set(sys.modules)\n"
    )
    plain = "-p", "no:hypothesispytest", "-p", "no:anyio"  # what others load is their affair
    words = "-m", "pytest", "-q", "-p", "no:cacheprovider", tmp_path, *plain
    assert "1 passed" in run_python(*words, cwd=tmp_path)


def test_the_plugin_is_there_without_being_asked_for(pytester):
    result = pytester.runpytest_inprocess("--markers")
    result.stdout.fnmatch_lines(["@pytest.mark.tree(path, *", "@pytest.mark.start(situation)*"])


def test_a_comparison_of_a_status_explains_itself(session):
    result = session(
        test_it="""
        from bt_manip.behaviours import ObjectExists
        from bt_manip.bt import NodeStatus

        def test_ball(trial):
            assert trial(ObjectExists("look", object="ball")).tick() is NodeStatus.SUCCESS
        """
    )
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "*assert FAILURE is SUCCESS",
            "*failed: look: the cell has no object 'ball' (tick 1, *",
            "*x look*",
        ]
    )


def test_the_marker_names_a_tree_beside_the_test(session):
    result = session(
        files={"pick.xml": PICK},
        test_it="""
        import pytest
        from bt_manip.testing.stubs import Stub

        @pytest.mark.tree("pick.xml")
        @pytest.mark.start("around the cube")
        def test_it_picks(tree_trial):
            tree_trial.tick_until("SUCCESS")
            tree_trial.assert_never_ticked("MoveHome")

        @pytest.mark.tree("pick.xml", substitute={"Grasp": Stub("FAILURE")})
        def test_it_goes_home(tree_trial):
            tree_trial.tick_until("SUCCESS", node="MoveHome")

        @pytest.mark.tree("pick_place", cubee="x")
        def test_settings_are_checked(tree_trial):
            pass
        """,
    )
    result.assert_outcomes(passed=2, errors=1)
    result.stdout.fnmatch_lines(["*has no key 'cubee'; did you mean 'cube'*"])


def test_the_coverage_of_trees_says_what_no_test_has_been_through(session):
    tests = """
        import pytest
        from bt_manip.testing.stubs import Stub

        @pytest.mark.tree("pick.xml", substitute={"Grasp": Stub(), "Lift": Stub()})
        def test_it_picks(tree_trial):
            tree_trial.tick_until("SUCCESS")
        """
    result = session("--tree-coverage", files={"pick.xml": PICK}, test_it=tests)
    result.assert_outcomes(passed=1)
    result.stdout.fnmatch_lines(
        [
            "*coverage of trees*",
            "pick.xml:Pick * 3/4 75 % *",
            "*MoveHome::7: never ticked",
        ]
    )
    result.stdout.no_fnmatch_line("*nothing there: never SUCCESS")


def test_a_conftest_adds_situations_and_builds_another_station(session):
    result = session(
        conftest="""
        import pytest
        from bt_manip.behaviours import MoveHome
        from bt_manip import build_station as build
        from bt_manip.testing.situations import play

        @pytest.fixture(scope="session")
        def build_station(parts):
            return lambda: build(parts, controller="gravity_compensated_pd", seed=4)

        @pytest.fixture
        def situations(situations):
            situations.add("home with the cube", lambda station: play(station, MoveHome()),
                           after="holding a cube over the table")
            return situations
        """,
        test_it="""
        import pytest

        @pytest.mark.start("home with the cube")
        def test_it(station, cell, robot):
            assert station.gripper.held == ("cube",)
            assert station.controller.kind == "gravity_compensated_pd"
            assert cell is station.cell and robot is station.robot

        @pytest.mark.start("home with the cub")
        def test_that(station):
            pass
        """,
    )
    result.assert_outcomes(passed=1, errors=1)
    result.stdout.fnmatch_lines(["*no start situation 'home with the cub'; did you mean 'home *"])


def test_each_module_has_the_station_that_it_builds(session):
    of_its_own = """
        import pytest
        from bt_manip import build_station as build

        @pytest.fixture(scope="session")
        def build_station(parts):
            return lambda: build(parts, controller="gravity_compensated_pd")

        def test_it(station):
            assert station.controller.kind == "gravity_compensated_pd"
        """
    usual = """
        def test_it(station):
            assert station.controller.kind == "computed_torque"
        """
    session(test_a=of_its_own, test_b=usual, test_c=of_its_own).assert_outcomes(passed=3)
    each_time = of_its_own.replace('(scope="session")', "")
    session(test_d=each_time).stdout.fnmatch_lines(["ScopeMismatch:*build_station*"])


def test_one_line_runs_all_trees_with_their_end_states(session, pytester):
    trees = pytester.path / "trees"
    trees.mkdir()
    leaf = '<root BTCPP_format="4"><BehaviorTree ID="T"><{}/></BehaviorTree></root>'
    (trees / "rest.xml").write_text(leaf.format('Sleep msec="20"'))
    (trees / "fall.xml").write_text(leaf.format('ObjectExists object="ball"'))
    (trees / "go.xml").write_text(leaf.format("OpenGripper"))
    result = session(
        "-v",
        test_it=f"""
        from bt_manip.testing import trees_of

        def the_table_is_there(station):
            assert "table" in station.cell.objects

        def there_is_a_ball(station):
            return "ball" in station.cell.objects

        test_trees = trees_of({str(trees)!r}, cycles=2, end_states={{
            "rest": the_table_is_there, "go": there_is_a_ball}})
        """,
    )
    result.assert_outcomes(passed=1, failed=2)
    result.stdout.fnmatch_lines(
        [
            "*test_trees?rest? PASSED*",
            "*0 of 2 cycles of *fall.xml' ended as they should*",
            "*cycle 0 failed: *ObjectExists*no object 'ball'*",
            "*cycle 1 did not end as it should: there_is_a_ball is False*",
        ]
    )


def test_a_plugins_module_is_loaded_by_itself(load_plugin):
    from bt_manip import hookimpl

    class Mine:
        @hookimpl
        def register_objects(self, register):
            register("thing", dict)

    parts = load_plugin(Mine()).parts
    assert "thing" in parts.objects and "cube" in parts.objects
    assert "push_button" not in parts.objects  # of an installed plugin

    class Misspelt:
        @hookimpl
        def register_object(self, register):
            register("thing", dict)

    with pytest.raises(AssertionError, match="did you mean 'register_objects'"):
        load_plugin(Misspelt())
