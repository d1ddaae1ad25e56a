"""Convert the Parquet table of demonstrations to a LeRobotDataset.

This script runs in an environment with lerobot and does not import bt-manip: the two require
different versions of the same packages.
"""

import io
import json
import sys
from pathlib import Path
from typing import Any

STATES = {"robot": "observation.state", "simulator": "observation.environment_state"}
"""Names of the concatenated observations of each group."""


def convert(table: Path, folder: Path, kind: str) -> None:
    """Write a LeRobotDataset.

    Observations other than images are concatenated: those that a robot can measure to
    ``observation.state``, the others to ``observation.environment_state``.

    Args:
        table: Table written by `write_demonstration_table`.
        folder: The folder to create.
        kind: Kind of the actions to write as ``action``.
    """
    import numpy as np
    from lerobot.datasets.lerobot_dataset import LeRobotDataset
    from PIL import Image
    from pyarrow import parquet, types

    file = parquet.ParquetFile(table)
    schema = file.schema_arrow
    manifest = json.loads(schema.metadata[b"bt_manip"])
    observed = [name for name in schema.names if name.startswith("obs.")]
    images = [name for name in observed if types.is_binary(schema.field(name).type)]
    states: dict[str, list[str]] = {}
    for name in observed:
        if name not in images:
            spec = manifest["observations"][name.removeprefix("obs.")]
            states.setdefault(STATES[spec["group"]], []).append(name)
    dataset: Any = None
    for group in range(file.num_row_groups):
        columns = file.read_row_group(group).to_pydict()
        for row in range(len(columns["step"])):
            values = {name: np.atleast_1d(column[row]) for name, column in columns.items()}
            frame: dict[str, Any] = {
                key: np.concatenate([values[name] for name in names]).astype(np.float32)
                for key, names in states.items()
            }
            frame |= {
                "action": np.array(columns[f"action.{kind}"][row], dtype=np.float32),
                "next.reward": np.array([columns["reward"][row]], dtype=np.float32),
                "next.done": np.array([columns["done"][row]]),
                "leaf": columns["leaf"][row],
            }
            for name in images:
                camera = name.removeprefix("obs.").removesuffix("_rgb")
                image = np.array(Image.open(io.BytesIO(columns[name][row])))
                frame[f"observation.images.{camera}"] = image
            if dataset is None:
                features = {name: feature(value) for name, value in frame.items()}
                features["action"]["names"] = manifest["actions"][kind]["names"]
                for key, names in states.items():
                    features[key]["names"] = [
                        f"{name.removeprefix('obs.')}.{i}"
                        for name in names
                        for i in range(values[name].size)
                    ]
                dataset = LeRobotDataset.create(
                    f"bt_manip/{folder.name}",
                    round(1.0 / manifest["step_s"]),
                    features,
                    root=folder,
                    robot_type=manifest["robot"],
                    use_videos=False,
                )
            dataset.add_frame({**frame, "task": columns["task"][row] or manifest["tree"]})
        dataset.save_episode()
    dataset.finalize()


def feature(value: Any) -> dict[str, Any]:
    """Return LeRobot's description of a value of a frame."""
    if isinstance(value, str):
        return {"dtype": "string", "shape": (1,), "names": None}
    if value.ndim == 3:
        return {"dtype": "image", "shape": value.shape, "names": ["height", "width", "channels"]}
    return {"dtype": str(value.dtype), "shape": value.shape, "names": None}


if __name__ == "__main__":
    convert(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3])
