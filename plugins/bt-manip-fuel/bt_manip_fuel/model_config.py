"""``model.config``: the SDF file of a model's folder."""

from pathlib import Path

from bt_manip.models import ModelError, read_xml

MODEL_CONFIG = "model.config"


def sdf_file(folder: Path) -> Path:
    """Return the SDF file of a model's folder, for the highest version of SDF.

    Raises:
        ModelError: If there is no ``model.config``, or it names no file inside the folder.
    """
    config = folder / MODEL_CONFIG
    if not config.is_file():
        raise ModelError(f"{folder}: not a model's folder, it has no {MODEL_CONFIG}")
    root = read_xml(config)
    choices = [
        (_version(element.get("version", "")), (element.text or "").strip())
        for element in root.iter("sdf")
    ]
    if not choices:
        raise ModelError(f"{config}: names no SDF file (<sdf version='...'>model.sdf</sdf>)")
    _, name = max(choices)
    path = folder / name
    if not name or not path.resolve().is_relative_to(folder.resolve()):
        raise ModelError(f"{config}: '{name}' is not a file inside the model's folder")
    if not path.is_file():
        raise ModelError(f"{config}: there is no '{name}' in the folder")
    return path


def _version(text: str) -> tuple[int, ...]:
    return tuple(int(part) if part.isdigit() else 0 for part in text.strip().split("."))
