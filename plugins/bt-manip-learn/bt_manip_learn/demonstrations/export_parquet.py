"""Export of demonstrations as an Apache Parquet table with a row per step."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from bt_manip.cell import png
from bt_manip.exceptions import BtManipError
from bt_manip.record import whole_file, writing

from .store import ALL, Demonstration, DemonstrationStore


def write_demonstration_table(
    store: DemonstrationStore, path: Path, observations: str = ALL
) -> int:
    """Write demonstrations as Parquet, one row per environment step.

    Columns are ``episode``, ``step``, ``t`` [s], ``obs.NAME``, ``action.KIND``, ``reward``,
    ``done``, ``task``, ``leaf`` and ``statuses``; images are encoded as PNG. The metadata entry
    ``bt_manip`` is the manifest. Each demonstration is a row group.

    Args:
        store: The demonstrations.
        path: The file; an existing one is replaced.
        observations: Group of observations, see `DemonstrationStore.observed`.

    Returns:
        Number of demonstrations.

    Raises:
        BtManipError: If there are no demonstrations.
    """
    import pyarrow
    from pyarrow import parquet

    n, writer = 0, None
    metadata = {"bt_manip": json.dumps(store.manifest)}
    with writing(path, "export"), whole_file(path) as out:
        for one in store:
            columns = {
                name: _column(pyarrow, array) for name, array in _columns(one, store, observations)
            }
            table = pyarrow.table(columns).replace_schema_metadata(metadata)
            if writer is None:
                writer = parquet.ParquetWriter(out, table.schema)
            writer.write_table(table, row_group_size=len(one))
            n += 1
        if writer is None:
            raise BtManipError(f"'{store.folder}' has no demonstrations to export")
        writer.close()
    return n


def _columns(
    one: Demonstration, store: DemonstrationStore, observations: str
) -> Iterator[tuple[str, Any]]:
    n = len(one)
    yield "episode", np.full(n, one.episode)
    yield "step", np.arange(n)
    yield "t", np.arange(n) * store.manifest["step_s"]
    for name, array in store.observed(one, observations).items():
        yield f"obs.{name}", array[:-1]
    for name, array in one.actions.items():
        yield f"action.{name}", array
    yield "reward", one.rewards
    yield "done", one.dones
    yield "task", [one.task or store.manifest["task"]] * n
    yield "leaf", list(one.leaves)
    yield "statuses", one.statuses


def _column(pyarrow: Any, array: Any) -> Any:
    """Return a column of numbers, of lists of a fixed size, or of PNG images."""
    if isinstance(array, list) or array.ndim == 1:
        return pyarrow.array(array)
    if array.dtype == np.uint8 and array.ndim == 4:
        return pyarrow.array([png(image) for image in array])
    flat = array.reshape(len(array), -1)
    return pyarrow.FixedSizeListArray.from_arrays(flat.ravel(), flat.shape[1])
