"""The notebook runs from its first cell to its last, and shows what it should."""

import copy
import re

import pytest

nbclient = pytest.importorskip("nbclient", reason="the extra [dev] is not installed")
for module in ("mcap", "bokeh", "ipykernel"):
    pytest.importorskip(module)

import nbformat  # noqa: E402

from tools.run_notebook import NOTEBOOK, run_notebook, stored  # noqa: E402


def code_cells(notebook):
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


@pytest.fixture(scope="module")
def executed():
    return run_notebook()


def shown(notebook, source):
    """Return the formats of the result of the only cell that ends with a line."""
    (cell,) = (c for c in code_cells(notebook) if c.source.endswith(source))
    return next(out.data for out in cell.outputs if "data" in out)


def printed(notebook):
    return "".join(
        out.text for cell in code_cells(notebook) for out in cell.outputs if "text" in out
    )


def displayed(notebook):
    """Return what cells show, by format, without pictures, which depend on drivers, and dates."""
    changing = re.compile(r'base64,[^"]*|\d{4}-\d\d-\d\dT[\d:+]*')
    outputs = [out.data for c in code_cells(notebook) for out in c.outputs if "data" in out]
    return [
        {form: changing.sub("", text) for form, text in data.items() if form != "image/png"}
        for data in outputs
    ]


def test_it_is_stored_with_the_outputs_of_its_code(executed):
    kept = nbformat.read(NOTEBOOK, as_version=4)
    assert printed(kept) == printed(executed), "run python tools/run_notebook.py"
    assert displayed(kept) == displayed(stored(copy.deepcopy(executed)))
    for cell in code_cells(kept):
        assert bool(cell.outputs) == (not cell.source.startswith("from bt_manip import"))


def test_trees_stations_results_and_recordings_show_themselves(executed):
    assert "<svg" in shown(executed, "\n\ntree = pick()\ntree")["image/svg+xml"]
    assert "RUNNING" in shown(executed, "tick())\ntree")["image/svg+xml"]
    assert "computed_torque" in shown(executed, "(seed=1)\nstation")["text/html"]
    assert "SUCCESS" in shown(executed, "\nresult")["text/html"]
    assert "not 500 N" in shown(executed, "500.0))")["text/html"]
    assert "Recording pick.mcap" in shown(executed, "\nrecording")["text/html"]


def test_cells_show_a_picture(opengl, executed):
    assert "image/png" in shown(executed, "tick()\nstation.cell")


def test_it_prints_what_was_recorded(executed):
    text = printed(executed)
    assert "pick and drop" in text
    (line,) = (one for one in text.splitlines() if one.startswith("largest tracking error"))
    assert 0.0 < float(line.split()[-2]) < 2.0
