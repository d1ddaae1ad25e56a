"""Convex decomposition of meshes for collision, cached because it is slow."""

import hashlib
import uuid

import numpy as np

from bt_manip.files import cache_root
from bt_manip.models.errors import ModelError
from bt_manip.models.meshes import Mesh

THRESHOLD = 0.05
"""Remaining concavity, relative to the size of the mesh."""


def can_decompose() -> bool:
    """Return whether coacd is installed."""
    from importlib.util import find_spec

    return find_spec("coacd") is not None


def convex_parts(mesh: Mesh) -> list[Mesh]:
    """Decompose a mesh into convex parts with nearly the same volume.

    It takes tens of seconds; the parts are cached by the content of the mesh.

    Raises:
        ModelError: If coacd is not installed or fails.
    """
    digest = hashlib.sha256(mesh.vertices.tobytes() + mesh.faces.astype(np.int64).tobytes())
    digest.update(f"coacd 1 {THRESHOLD}".encode())
    path = cache_root() / "convex" / f"{digest.hexdigest()[:32]}.npz"
    if path.is_file():
        with np.load(path, allow_pickle=False) as arrays:
            numbers = range(len(arrays.files) // 2)
            return [Mesh(arrays[f"v{i}"], arrays[f"f{i}"], watertight=True) for i in numbers]
    parts = decompose(mesh)
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{uuid.uuid4().hex}.npz")
    arrays = {f"v{i}": p.vertices for i, p in enumerate(parts)}
    arrays |= {f"f{i}": p.faces for i, p in enumerate(parts)}
    np.savez_compressed(part, allow_pickle=False, **arrays)
    part.replace(path)
    return parts


def decompose(mesh: Mesh) -> list[Mesh]:
    """Decompose a mesh into convex parts without the cache; raise as `convex_parts` does."""
    if not can_decompose():
        raise ModelError("convex parts need coacd: pip install 'bt-manip[convex]'")
    import coacd

    coacd.set_log_level("error")
    try:
        parts = coacd.run_coacd(coacd.Mesh(mesh.vertices, mesh.faces), threshold=THRESHOLD, seed=0)
    except Exception as error:  # a C++ library without documented exceptions
        raise ModelError(f"no convex parts were found: {error}") from None
    return [Mesh(np.asarray(v), np.asarray(f), watertight=True) for v, f in parts]
