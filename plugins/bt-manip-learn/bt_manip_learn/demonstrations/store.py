"""Folders of demonstrations: a manifest, and one HDF5 file per episode."""

import hashlib
import json
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from bt_manip.exceptions import BtManipError
from bt_manip.files import read_text
from bt_manip.record import (
    FileInUseError,
    identity_differences,
    open_output,
    reading,
    whole_file,
    writing,
)

MANIFEST_FORMAT = "bt-manip demonstrations"
MANIFEST_VERSION = 1
MANIFEST = "manifest.json"
LOCK = "recording.lock"

ALL = "all"
"""The observations of all groups."""

MAX_EPISODE_BYTES = 2**32
"""Size of the arrays of the largest episode that is read [bytes]; a small file may claim more."""

_MAX_MANIFEST_BYTES = 2**26  # 64 MiB; an episode takes 200 bytes
_EPISODE = re.compile(r"episode_(\d{6,})\.h5")


@dataclass(frozen=True)
class Demonstration:
    """One episode of an expert, sampled at the rate of the environment.

    Row ``i`` of each array belongs to environment step ``i`` of ``n``; observations and states have
    one more row, after the last step.

    Attributes:
        episode: Number of the episode; with the seed of the manifest, it determines the start.
        success: Whether the tree succeeded and its goal held.
        reason: Reason of a failure; empty on success.
        digest: SHA-256 over the states and node statuses after each step.
        observations: By name.  # (n + 1, ...)
        actions: By kind: the action that reproduces the expert's step.  # (n, size)
        rewards: The rewards.  # (n,)
        dones: Whether the episode ended with the step.  # (n,)
        states: State of the physics, MuJoCo's ``mjSTATE_INTEGRATION``.  # (n + 1, size)
        leaves: Paths of the running leaves at the end of the step, joined by ``"; "``.  # (n,)
        statuses: `bt_manip.bt.NodeStatus` of each node at the end of the step.  # (n, nodes)
        task: Sentence that describes the task; empty: that of the manifest.
    """

    episode: int
    success: bool
    reason: str = ""
    digest: str = ""
    observations: Mapping[str, np.ndarray] = field(default_factory=dict)
    actions: Mapping[str, np.ndarray] = field(default_factory=dict)
    rewards: np.ndarray = field(default_factory=lambda: np.zeros(0))
    dones: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=bool))
    states: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    leaves: tuple[str, ...] = ()
    statuses: np.ndarray = field(default_factory=lambda: np.zeros((0, 0), dtype=np.uint8))
    task: str = ""

    def __len__(self) -> int:
        """Return the number of environment steps."""
        return len(self.rewards)


_ARRAYS = ("rewards", "dones", "states", "statuses")
_FACTS = ("episode", "success", "reason", "digest", "task")
_IDENTITY = "identity"


class DemonstrationStore:
    """The demonstrations in a folder.

    Files are complete: each is written under another name and then renamed. A discarded failed
    episode has a file without steps, so that it is not run again.

    Attributes:
        folder: The folder.
        manifest: Identity and contents of the demonstrations, as plain data.

    Raises:
        BtManipError: If the folder has no manifest of this version.
    """

    def __init__(self, folder: Path | str) -> None:
        self.folder = Path(folder)
        path = self.folder / MANIFEST
        with reading(path, "manifest of demonstrations"):
            self.manifest: dict[str, Any] = json.loads(read_text(path, _MAX_MANIFEST_BYTES))
            found = self.manifest["format"], self.manifest["version"]
        if found != (MANIFEST_FORMAT, MANIFEST_VERSION):
            raise BtManipError(
                f"'{path}' is of {found[0]} {found[1]}, not {MANIFEST_FORMAT} {MANIFEST_VERSION}"
            )

    @classmethod
    def create(cls, folder: Path | str, identity: Mapping[str, Any]) -> "DemonstrationStore":
        """Create a folder, or open a folder with demonstrations of the same identity.

        Args:
            folder: The folder.
            identity: Identity of the demonstrations, as plain data.

        Raises:
            BtManipError: If it cannot be written, or its manifest or one of its files is of another
                identity.
        """
        folder = Path(folder)
        if not (folder / MANIFEST).exists():
            with writing(folder, "folder"):
                folder.mkdir(parents=True, exist_ok=True)
                if any(folder.iterdir()):
                    raise BtManipError(f"'{folder}' holds other files: choose an empty folder")
            digest = hashlib.sha256(json.dumps(identity).encode()).hexdigest()
            head = {"format": MANIFEST_FORMAT, "version": MANIFEST_VERSION, _IDENTITY: digest}
            _write_manifest(folder, {**head, **identity})
        store = cls(folder)
        there, here = store.manifest, json.loads(json.dumps(identity))
        other = identity_differences({key: there.get(key) for key in here}, here)
        if other:
            shown = [other["tree"]] if "tree" in other else [*other.values()][:5]
            raise BtManipError(
                f"'{folder}' holds demonstrations that differ: {'; '.join(shown)}: "
                "choose another folder, or the same files, options and versions"
            )
        for episode in store.episodes():
            with store._opened(episode):
                pass
        return store

    @contextmanager
    def recording(self) -> Iterator[None]:
        """Lock the folder for recording; other processes may still read it.

        Raises:
            FileInUseError: If another process is recording into it.
        """
        path = self.folder / LOCK
        try:
            with writing(path, "lock"):
                file = open_output(path)
        except FileInUseError:
            raise FileInUseError(f"'{self.folder}' is being recorded by another process") from None
        with file:
            try:
                yield
            finally:
                with suppress(OSError):
                    path.unlink()

    def check_actions(self, kind: str) -> None:
        """Check that actions of a kind were recorded.

        Raises:
            BtManipError: If not.
        """
        kinds = self.manifest["actions"]
        if kind not in kinds:
            raise BtManipError(
                f"the demonstrations have no actions '{kind}', but {', '.join(kinds)}"
            )

    def observed(self, one: Demonstration, group: str) -> dict[str, np.ndarray]:
        """Return the observations of a demonstration.

        Args:
            one: The demonstration.
            group: ``"robot"``: observations that a robot can measure; ``"all"``.
        """
        specs, found = self.manifest["observations"], one.observations.items()
        return {name: x for name, x in found if group in (ALL, specs[name]["group"])}

    def path(self, episode: int) -> Path:
        """Return the file of an episode."""
        return self.folder / f"episode_{episode:06}.h5"

    def episodes(self) -> list[int]:
        """Return the numbers of the episodes that have a file."""
        found = (_EPISODE.fullmatch(path.name) for path in self.folder.iterdir())
        return sorted(int(match[1]) for match in found if match)

    def write(self, demonstration: Demonstration) -> None:
        """Write the file of an episode; replace an existing one.

        Raises:
            RecordingError: If it cannot be written.
        """
        import h5py

        buffer = BytesIO()
        with h5py.File(buffer, "w") as file:
            file.attrs.update({key: getattr(demonstration, key) for key in _FACTS})
            file.attrs[_IDENTITY] = self.manifest[_IDENTITY]
            if len(demonstration):
                for group in ("observations", "actions"):
                    for name, array in getattr(demonstration, group).items():
                        put_array(file, f"{group}/{name}", array)
                for name in _ARRAYS:
                    put_array(file, name, getattr(demonstration, name))
                file.create_dataset("leaves", data=demonstration.leaves, dtype=h5py.string_dtype())
        path = self.path(demonstration.episode)
        with writing(path, "demonstration"), whole_file(path, sync=False) as out:
            out.write(buffer.getbuffer())

    def write_lost(self, episode: int, error: Exception) -> None:
        """Write the file of an episode whose worker processes died."""
        self.write(Demonstration(episode, False, str(error)))

    def read(self, episode: int) -> Demonstration:
        """Read the file of an episode.

        Raises:
            BtManipError: If there is no such file, or it is not a demonstration of this identity.
        """
        with self._opened(episode) as file:
            facts = _facts(file)
            if "rewards" not in file:
                return Demonstration(**facts)
            groups: dict[str, Any] = {
                group: {name: data[()] for name, data in file[group].items()}
                for group in ("observations", "actions")
            }
            arrays = {name: file[name][()] for name in _ARRAYS}
            leaves = tuple(text.decode() for text in file["leaves"][()])
            return Demonstration(**facts, **groups, **arrays, leaves=leaves)

    def __iter__(self) -> Iterator[Demonstration]:
        """Iterate over the demonstrations with steps, by number."""
        for episode in self.episodes():
            demonstration = self.read(episode)
            if len(demonstration):
                yield demonstration

    def write_outcomes(self) -> list[dict[str, Any]]:
        """Write the outcomes and digests of all episodes into the manifest, and return them."""
        outcomes = []
        for episode in self.episodes():
            with self._opened(episode) as file:
                steps = len(file["rewards"]) if "rewards" in file else 0
                outcomes.append({**_facts(file), "steps": steps})
        self.manifest["episodes"] = outcomes
        _write_manifest(self.folder, self.manifest)
        return outcomes

    @contextmanager
    def _opened(self, episode: int) -> Iterator[Any]:
        """Open the HDF5 file of an episode, which must have the identity of the manifest."""
        import h5py

        path = self.path(episode)
        with reading(path, "demonstration"), h5py.File(path) as file:
            if file.attrs.get(_IDENTITY) != self.manifest.get(_IDENTITY):
                raise BtManipError(f"'{path}' is of another recording than the folder: remove it")
            sizes: list[int] = []
            file.visititems(lambda name, item: sizes.append(getattr(item, "nbytes", 0)))
            if sum(sizes) > MAX_EPISODE_BYTES:
                raise BtManipError(
                    f"'{path}' has arrays of {sum(sizes) / 2**30:.0f} GB, at most "
                    f"{MAX_EPISODE_BYTES / 2**30:g} GB are read"
                )
            yield file


def read_demonstrations(folder: Path | str) -> DemonstrationStore:
    """Open a folder of demonstrations, to iterate over.

    Args:
        folder: Folder written by ``bt-manip demos --to``.

    Raises:
        BtManipError: If the folder holds no demonstrations.
    """
    return DemonstrationStore(folder)


def put_array(group: Any, name: str, array: np.ndarray) -> None:
    """Add an array to an HDF5 group; images are compressed individually."""
    image = array.dtype == np.uint8 and array.ndim == 4
    options = {"chunks": (1, *array.shape[1:]), "compression": "gzip"} if image else {}
    group.create_dataset(name, data=array, **options)


def _facts(file: Any) -> dict[str, Any]:
    """Return the attributes of an episode's HDF5 file, as plain data."""
    facts = {key: file.attrs[key] for key in _FACTS}
    return facts | {"episode": int(facts["episode"]), "success": bool(facts["success"])}


def _write_manifest(folder: Path, manifest: Mapping[str, Any]) -> None:
    path = folder / MANIFEST
    with writing(path, "manifest"), whole_file(path) as file:
        file.write(json.dumps(manifest, indent=1).encode() + b"\n")
