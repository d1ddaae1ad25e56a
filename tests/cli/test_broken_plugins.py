"""A broken plugin costs a warning, or the run that needs it, and always says whose fault it is."""

import json
import textwrap

import numpy as np
import pytest

HEAD = """
    import time
    from pathlib import Path

    import numpy as np

    from bt_manip import hookimpl
    from bt_manip.bt import Action, Status
    from bt_manip.control import GravityCompensatedPD
"""


@pytest.fixture
def folder(tmp_path):
    """Give a folder of plugins, and how to write one."""
    path = tmp_path / "plugins"
    path.mkdir()

    def write(name: str, source: str, head: str = HEAD):
        (path / f"{name}.py").write_text(textwrap.dedent(head) + textwrap.dedent(source))
        return path

    return write


def test_what_fails_while_loading_is_one_warning_and_the_run_goes_on(bt_manip, folder, trees):
    source = "@hookimpl\ndef register_objects(register): raise RuntimeError('not today')"
    plugins = folder("bad", source)
    folder("good", "@hookimpl\ndef register_objects(register): register('good_thing', dict)")
    code, _, err = bt_manip("run", f"{trees}:quick", "--plugins-dir", plugins)
    assert code == 0
    (line,) = err.splitlines()
    assert line.startswith("Warning: plugin 'bad'")
    assert "RuntimeError: not today" in line
    assert str(plugins / "bad.py") in line
    assert "--block bad" in line
    listed = bt_manip("--plugins-dir", plugins, "list", "objects")
    assert "good_thing" in listed.out


OBSERVER = """
    @hookimpl
    def {hook}(station):
        raise RuntimeError("cannot\\nlook")


    @hookimpl
    def cycle_ended(status):
        Path({log!r}).write_text(status)
"""

WITNESS = """
    @hookimpl
    def before_tick(station):
        with Path({log!r}).open("a") as file:
            file.write("tick ")
"""


@pytest.mark.parametrize("hook", ["after_compile", "after_tick"])
def test_an_observer_that_raises_is_one_warning_and_changes_nothing(
    digest, folder, trees, tmp_path, hook
):
    plugins = folder("bad", OBSERVER.format(hook=hook, log=str(tmp_path / "bad")))
    folder("good", WITNESS.format(log=str(tmp_path / "good")))
    watched, err = digest(f"{trees}:quick", "--plugins-dir", plugins)
    (line,) = err.splitlines()
    assert line.startswith("Warning: plugin 'bad'")
    assert "RuntimeError: cannot look" in line and "--block bad" in line
    assert str(plugins / "bad.py") in line
    assert not (tmp_path / "bad").exists()  # it is not asked again
    assert len((tmp_path / "good").read_text().split()) > 1
    assert digest(f"{trees}:quick") == (watched, "")


RAISING = """
    from bt_manip.behaviours import MoveHome


    class Trip(Action):
        def initialise(self):
            self.ticks = 0

        def setup(self, *, arm, **_):
            self.arm = arm

        def update(self):
            self.ticks += 1
            if self.ticks == 1:
                self.arm.move_to_configuration(self.arm.q + 0.5)
            if self.ticks == 20:
                raise ValueError("stumbled")
            return Status.RUNNING


    @hookimpl
    def register_behaviours(register):
        register(Trip)
"""

UPDATE = "def update(self): return Status.SUCCESS"
IN_BETWEEN = {
    "exits": ("def update(self): raise SystemExit(0)", 3, "SystemExit: 0"),
    "raises GeneratorExit": ("def update(self): raise GeneratorExit", 3, "GeneratorExit"),
    "returns nothing": ("def update(self): pass", 1, "update() returned None; expected a Status"),
    "asks for what is not there": (
        f"def setup(self, *, camera, **_): pass\n    {UPDATE}",
        3,
        "setup: Odd.setup() missing 1 required keyword-only argument: 'camera'",
    ),
    "forgets its base's setup": (
        f"def setup(self, **_): pass\n    {UPDATE}",
        3,
        "'Odd' object has no attribute 'cell'",
    ),
    "forgets its base's init": (
        f"def __init__(self, name=None): self.count = 0\n    {UPDATE}",
        2,
        "Odd: its class has an __init__ that does not call super's",
    ),
}


@pytest.mark.parametrize(("body", "exit_code", "reason"), IN_BETWEEN.values(), ids=list(IN_BETWEEN))
def test_a_behaviour_that_fails_in_code_of_ours_is_named_too(
    bt_manip, folder, task, tmp_path, body, exit_code, reason
):
    source = f"""
from bt_manip.behaviours import CellBehaviour

class Odd(CellBehaviour):
    {body}

@hookimpl
def register_behaviours(register): register(Odd)
"""
    plugins = folder("clumsy", source)
    tree, report = task("<Odd/>"), tmp_path / "report.json"
    code, _, err = bt_manip("run", tree, "--plugins-dir", plugins, "--report", report)
    last = err.splitlines()[-1]
    assert code == exit_code and reason in last
    if code != 2:  # found before anything runs
        assert "plugin 'clumsy'" in last
        assert json.loads(report.read_text())["status"] == "ERROR"


@pytest.mark.parametrize("asked_by", ["a tree", "a scene"])
def test_an_object_that_cannot_be_made_is_named(bt_manip, folder, trees, tmp_path, asked_by):
    source = "@hookimpl\ndef register_objects(register): register('odd', lambda: None)\n"
    plugins = folder("quack", source)
    options = ["pick_place", "--set", "cube=odd"]
    if asked_by == "a scene":
        scene = tmp_path / "odd.toml"
        scene.write_text("[[objects]]\nmodel = 'odd'\nposition = [0.0, 0.0, 0.0]\n")
        options = [f"{trees}:quick", "--scene", scene]
    code, _, err = bt_manip("run", *options, "--plugins-dir", plugins)
    last = err.splitlines()[-1]
    assert code == 3 and "plugin 'quack'" in last
    reason = "object 'odd' cannot be made: its factory gave None, which has no 'mjcf_model'"
    assert f"{reason}; expected a composer.Entity" in last


CONTROLLER = """
    class Odd(GravityCompensatedPD):
        kind = "odd"
        saturates = False
        steps = 0

        def compute(self, q, v, q_ref, v_ref, a_ref):
            self.steps += 1
            tau = super().compute(q, v, q_ref, v_ref, a_ref)
            if self.steps > {after}:
                {then}
            return tau


    @hookimpl
    def register_controllers(register):
        register("odd", Odd)
"""

FAULTS = {
    "nan": ("tau[2] = np.nan", "returned nan for the torque of joint 'joint3'"),
    "exits": ("raise SystemExit(0)", "raised SystemExit: 0"),
    "works in place on what it is given": ("q -= q_ref", "raised ValueError: output array is read"),
    "is not at fault": ("pass", "stumbled"),  # but the behaviour
}


@pytest.mark.parametrize(("then", "reason"), FAULTS.values(), ids=list(FAULTS))
def test_a_broken_controller_or_behaviour_ends_the_run_with_the_arm_braked_and_is_named(
    bt_manip, folder, task, tmp_path, then, reason
):
    plugins = folder("quack", CONTROLLER.format(after=100, then=then))
    folder("clumsy", RAISING if then == "pass" else RAISING.replace("== 20", "== 2000"))
    tree, report, trace = task("<Trip/>"), tmp_path / "report.json", tmp_path / "t.npz"
    code, _, err = bt_manip(
        "run", tree, "--controller", "odd", "--plugins-dir", plugins,
        "--report", report, "--record", f"trace={trace}",
    )  # fmt: skip
    last, read = err.splitlines()[-1], json.loads(report.read_text())
    culprit = "plugin 'clumsy': " if then == "pass" else "plugin 'quack'"
    assert code == 3 and culprit in last and reason in last
    assert read["status"] == "ERROR" and reason in read["error"]
    assert ("controller 'odd'" in last) == (then != "pass")
    with np.load(trace) as rows:
        v_ref = rows["v_ref"]
        assert np.isfinite(rows["tau"]).all()
        assert abs(rows["v"][-1]).max() < 0.2  # the measured arm has followed to rest
    assert abs(v_ref).max() > 0.1 and not v_ref[-1].any()
    assert abs(np.diff(v_ref, axis=0)).max() < 0.05  # it is braked, not stopped dead


def test_a_slow_controller_is_one_warning_and_changes_no_result(digest, folder, trees):
    plugins = folder("snail", CONTROLLER.format(after=0, then="time.sleep(0.002)"))
    tree = f"{trees}:quick"
    slow, err = digest(tree, "--controller", "odd", "--plugins-dir", plugins)
    (line,) = err.splitlines()
    assert line.startswith("Warning: controller 'odd' of plugin 'snail'")
    assert "is slow" in line and "%" in line
    assert digest(tree, "--controller", "gravity_compensated_pd") == (slow, "")
