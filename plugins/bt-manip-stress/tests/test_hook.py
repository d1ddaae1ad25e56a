"""The hook that the package declares; its plugin is the example of the README."""

import re
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from bt_manip.bt import Sleep
from bt_manip.exceptions import BtManipError
from bt_manip.plugins import load_plugins
from bt_manip.testing import Trial
from bt_manip_stress import Fault, parameter
from bt_manip_stress.plugin import check_fault

README = Path(__file__).resolve().parents[1] / "README.md"


@pytest.fixture
def with_wind(tmp_path, monkeypatch):
    """Load the example."""
    (code,) = re.findall(r"```python\n(.*?register_faults.*?)```", README.read_text(), re.DOTALL)
    (tmp_path / "of_register_faults.py").write_text(code)
    monkeypatch.setenv("BT_MANIP_PLUGINS_DIR", str(tmp_path))
    return load_plugins(warn=pytest.fail).parts


def test_register_faults_makes_faults_that_disturb_a_run(with_wind, station, cell):
    station = replace(station, parts=with_wind)
    before = cell.pose("cube").translation[0]
    modifiers = {"fault": ("wind at=rest force=2",)}
    Trial(station, Sleep("rest", msec=500), modifiers=modifiers).until_done()
    assert cell.pose("cube").translation[0] > before + 0.05


PROBLEMS = {
    "is no dataclass that derives from Fault": """
class Wind(Fault):
    def begin(self):
        pass
""",
    "is incomplete: it lacks begin": """
@dataclass
class Wind(Fault):
    pass
""",
    "the default of 'force' is no number or text": """
@dataclass
class Wind(Fault):
    force: float = parameter(None, "")

    def begin(self):
        pass
""",
}


@pytest.mark.parametrize(("problem", "code"), PROBLEMS.items(), ids=PROBLEMS)
def test_a_class_that_is_no_fault_is_refused(problem, code):
    names = {"dataclass": dataclass, "Fault": Fault, "parameter": parameter}
    exec(code, names)
    with pytest.raises(BtManipError, match=f"fault 'wind'.* {problem}"):
        check_fault("wind", names["Wind"])
