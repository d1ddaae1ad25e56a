"""Where the model files of a description are."""

from pathlib import Path

from .errors import RobotError

MENAGERIE = "menagerie:"
"""What the address of a model of MuJoCo Menagerie begins with."""


def locate_model(model: str, where: str) -> Path:
    """Give the file of a model.

    Args:
        model: A path, or ``menagerie:NAME`` or ``menagerie:NAME/ENTRY``.
        where: Who asks, for the message.

    Raises:
        RobotError: When there is no such file, or it cannot be fetched.
    """
    if model.startswith(MENAGERIE):
        return _from_menagerie(model, where)
    path = Path(model)
    if not path.is_file():
        raise RobotError(f"{where}: no model file {model}")
    return path


def _from_menagerie(model: str, where: str) -> Path:
    # Imported here: most robots need neither the package that fetches, nor the network.
    from bt_manip.models import ModelError, menagerie_file

    try:
        return menagerie_file(model.removeprefix(MENAGERIE))
    except ModelError as error:
        raise RobotError(f"{where}: model '{model}': {error}") from error
