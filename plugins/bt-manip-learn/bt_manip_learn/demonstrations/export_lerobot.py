"""Export of demonstrations as a LeRobotDataset, by lerobot in a separate environment."""

import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

from bt_manip.exceptions import BtManipError

from . import lerobot_script
from .export_parquet import write_demonstration_table
from .store import ALL, DemonstrationStore


def write_lerobot(
    store: DemonstrationStore,
    folder: Path,
    actions: str,
    python: str,
    observations: str = "",
) -> int:
    """Write demonstrations as a `LeRobotDataset`, by lerobot itself.

    Args:
        store: The demonstrations.
        folder: The folder to create.
        actions: Kind of the actions to write as ``action``.
        python: Python interpreter of an environment with lerobot.
        observations: Group of observations, see `DemonstrationStore.observed`. Values that only a
            simulator knows become ``observation.environment_state``. Default: ``"robot"`` with
            images, otherwise ``"all"``, since policies need images or a state of the environment.

    Returns:
        Number of demonstrations.

    Raises:
        BtManipError: If there are no demonstrations, the folder exists, or the conversion fails.
    """
    store.check_actions(actions)
    if folder.exists():
        raise BtManipError(f"'{folder}' exists: choose another folder, which LeRobot makes")
    with TemporaryDirectory() as temporary:
        table = Path(temporary, "demonstrations.parquet")
        group = observations or ("robot" if store.manifest["images"]["kinds"] else ALL)
        n = write_demonstration_table(store, table, group)
        script = str(lerobot_script.__file__)
        command = [python, script, str(table), str(folder.absolute()), actions]
        try:
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        except OSError as error:
            raise BtManipError(f"'{python}' does not run: {error.strerror}") from error
        except subprocess.CalledProcessError as error:
            lines = error.stderr.decode(errors="replace").strip().splitlines()
            reason = lines[-1] if lines else f"exit code {error.returncode}"
            raise BtManipError(f"lerobot in '{python}' failed: {reason}") from error
    return n
