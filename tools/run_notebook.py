"""Run the notebook of ``examples/``, and store it with its outputs.

Bokeh's scripts, 1 MB, are left out of the file: a reader on the web runs none.
"""

import tempfile
from pathlib import Path

import nbclient
import nbformat

NOTEBOOK = Path(__file__).resolve().parent.parent / "examples" / "tutorial.ipynb"


BOKEH = ("bokeh", "data-root-id")
"""What marks Bokeh's outputs."""


def run_notebook() -> nbformat.NotebookNode:
    """Return the notebook with the outputs of a run in an empty folder."""
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        client = nbclient.NotebookClient(
            notebook, timeout=300, resources={"metadata": {"path": folder}}, kernel_name="python3"
        )
        return client.execute()


def stored(notebook: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """Remove Bokeh's outputs, and what differs between runs."""
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)
        if cell.cell_type != "code":
            continue
        cell.outputs = [one for one in cell.outputs if not any(mark in str(one) for mark in BOKEH)]
        for output in cell.outputs:
            if len(output.get("data", {})) > 1:
                output.data.pop("text/plain")  # an address
    notebook.metadata.language_info = {"name": "python"}
    return notebook


if __name__ == "__main__":
    nbformat.write(stored(run_notebook()), NOTEBOOK)
