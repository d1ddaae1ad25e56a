"""Collision of a body by convex parts of its meshes, in place of their hulls."""

from typing import Any

import mujoco

from bt_manip.models import Mesh, convex_parts

_COLLIDES = ("contype", "conaffinity", "condim", "friction", "solref", "solimp", "margin", "gap")
_MESH = int(mujoco.mjtGeom.mjGEOM_MESH)


def decompose_meshes(body: Any, alone: mujoco.MjModel) -> None:
    """Let a body collide by convex parts of its meshes; masses stay those of the meshes.

    Args:
        body: The body, as a PyMJCF element.
        alone: The model, compiled on its own.

    Raises:
        ModelError: If coacd is not installed or fails.
    """
    first = int(alone.body(body.full_identifier).geomadr[0])
    for i, geom in enumerate(list(body.geom), start=first):
        touches = alone.geom_contype[i] or alone.geom_conaffinity[i]
        if int(alone.geom_type[i]) != _MESH or not touches:
            continue
        mesh, same = alone.mesh(int(alone.geom_dataid[i])), {"dclass": geom.dclass}
        same |= {key: getattr(geom, key) for key in _COLLIDES}
        vertices = alone.mesh_vert[int(mesh.vertadr[0]) :][: int(mesh.vertnum[0])]
        faces = alone.mesh_face[int(mesh.faceadr[0]) :][: int(mesh.facenum[0])]
        for k, part in enumerate(convex_parts(Mesh(vertices.astype(float), faces))):
            name = f"{body.name}_convex{i - first}_{k}"
            asset = body.root.asset.add("mesh", name=name, vertex=part.vertices.ravel())
            body.add(
                "geom", name=name, type="mesh", mesh=asset, pos=alone.geom_pos[i],
                quat=alone.geom_quat[i], mass=0.0, group=3,
                **{key: value for key, value in same.items() if value is not None},
            )  # fmt: skip
        geom.contype = geom.conaffinity = 0
