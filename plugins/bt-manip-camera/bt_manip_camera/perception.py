"""What frames show: named objects, and the believed cell that is kept up to date with them."""

import contextlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
import pinocchio as pin

from bt_manip.cell import Cell, CellError, as_object
from bt_manip.runner import CommandedRobot
from bt_manip.scenes import ExpectedObjects

from .detections import Detections
from .estimation import Estimate, KnownObject, fit_pose, instead, name_clusters
from .frame import Frame
from .segmentation import find_clusters

MOVED = 5e-4
"""Distance from which the believed pose of an object is changed [m]."""


@dataclass(frozen=True)
class Sighting:
    """What a frame shows.

    Attributes:
        found: The estimated poses, by name. They are those of the objects' origins.
        missing: Why wanted objects are not seen, and why others that could be there are not named.
        gone: Names of those that are not any more where they were seen before.
        detections: The same, to be shown.
    """

    found: Mapping[str, Estimate]
    missing: Mapping[str, str]
    gone: frozenset[str]
    detections: Detections


class Perception:
    """Finds expected objects in frames, and lets them be there in the cell of the tree.

    Args:
        cell: The cell of the tree.
        poses: The expected objects; None: only objects of the cell are found.
        robots: The robots of the tree, whose grippers may hold objects.
        models: Makes objects.
    """

    def __init__(
        self, cell: Cell, poses: ExpectedObjects | None, robots: Mapping[str, CommandedRobot],
        models: Any,
    ) -> None:  # fmt: skip
        self._cell, self._poses, self._robots, self._models = cell, poses, robots, models

    @property
    def source(self) -> Any:
        """The `SeenPoses`; None where the tree knows the physics."""
        source = None if self._poses is None else self._poses.source
        return source if hasattr(source, "report") else None

    def see(self, frame: Frame, surface: float, wanted: Iterable[str] = ()) -> Sighting:
        """Find all expected objects in a frame.

        Args:
            frame: The frame.
            surface: Height of their support in the world [m].
            wanted: Names of objects that must be among those which could be there.

        Raises:
            CellError: If a wanted object is not known, or has a shape that is not recognised.
        """
        entities, known = {}, {}
        expected = () if self._poses is None else self._poses.source.expected
        for name in dict.fromkeys((*wanted, *(one.name for one in expected))):
            if name not in wanted and self._is_held(name):
                continue
            entities[name] = self.entity(name)
            with contextlib.nullcontext() if name in wanted else contextlib.suppress(CellError):
                known[name] = known_object(name, entities[name])
        clusters = find_clusters(frame, surface)
        believed, gone = {}, set[str]()
        for name, one in known.items():
            if self.source is None or name not in self._cell.entities:
                continue
            centre = self._cell.pose(name) * centre_of(entities[name], one)
            believed[name] = centre.translation[:2]
            away = sees_through(frame, centre.translation, 0.25 * one.size[2])
            if away or name in self.source.lost:
                gone.add(name)
        named, refused = name_clusters(clusters, list(known.values()), believed, gone)
        found, fits = {}, []
        for name, cluster in named.items():
            fitted = fit_pose(cluster, known[name], frame.time)
            fits.append((fitted, known[name]))
            origin = centre_of(entities[name], known[name]).inverse()
            found[name] = replace(fitted, T_wo=fitted.T_wo * origin)
        missing = {n: instead(clusters, known[n]) for n in wanted if n not in found} | refused
        nameless = [one for one in clusters if not any(one is other for other in named.values())]
        shown = Detections(frame, nameless, fits)
        return Sighting(found, missing, frozenset(gone - found.keys()), shown)

    def believe(self, found: Estimate, camera: str) -> None:
        """Let an object be where it was seen in what the tree knows.

        Args:
            found: The estimate, of its origin.
            camera: Name of the camera.
        """
        source, name = self.source, found.name
        if source is None:
            return
        assert self._poses is not None
        source.report(replace(found, camera=camera))
        if name not in self._cell.entities:
            self._poses.add(name)
        elif not self._is_held(name):  # else it moves with the hand
            now = self._cell.pose(name)
            moved = np.linalg.norm(now.translation - found.T_wo.translation) > MOVED
            if moved or not now.isApprox(found.T_wo, 0.01):
                self._cell.move(name, found.T_wo, overlap=0.01)

    def lose(self, names: Iterable[str]) -> None:
        """Note that objects are gone from where they were seen; held ones are in the hand."""
        for name in names:
            if self.source is not None and not self._is_held(name):
                self.source.lose(name)

    def _is_held(self, name: str) -> bool:
        grippers = (one.gripper for one in self._robots.values() if one.gripper is not None)
        return any(name in gripper.held for gripper in grippers)

    def entity(self, name: str) -> Any:
        """Return the object of the cell, or an expected one as it is described.

        Raises:
            CellError: If there is none of this name.
        """
        if name not in self._cell.entities and self._poses is not None:
            for one in self._poses.source.expected:
                if one.name == name:
                    return self._models.nominal(one.model, **one.parameters)
        return self._cell.find(name)


def known_object(name: str, entity: Any) -> KnownObject:
    """Return size and colour of an object: a box, or an upright cylinder.

    Args:
        name: Its name.
        entity: The object, whose collision geometry is one box or one cylinder.

    Raises:
        CellError: If it has another shape.
    """
    geoms = getattr(entity, "collision_geoms", None)
    if geoms is None:
        geoms = entity.mjcf_model.find_all("geom", exclude_attachments=True)
    if [geom.type for geom in geoms] not in (["box"], ["cylinder"]):
        raise CellError(f"'{name}' is no single box or cylinder, and nothing else is recognised")
    (geom,) = geoms
    opaque = geom.rgba is not None and geom.material is None and geom.rgba[3] == 1.0
    seen = tuple(float(part) for part in geom.rgba[:3]) if opaque else None
    lengths = [2.0 * float(half) for half in geom.size]
    if geom.type == "cylinder":
        diameter, height = lengths[:2]
        lengths = [diameter, diameter, height]
    return KnownObject(name, geom.type, cast(Any, tuple(lengths)), cast(Any, seen))


def centre_of(entity: Any, known: KnownObject) -> pin.SE3:
    """Return the pose of an upright object's centre in the frame of its origin."""
    one = as_object(entity)
    x, y = one.centre_offset[:2]
    return pin.SE3(np.eye(3), np.array([x, y, 0.5 * known.size[2] - one.rest_height]))


def sees_through(frame: Frame, point: np.ndarray, margin: float) -> bool:
    """Return whether a frame shows what is behind a point, so that nothing can be there.

    Args:
        frame: The frame.
        point: The point in the world [m].  # (3,)
        margin: Distance behind it from which something is behind it [m].
    """
    z = frame.T_wc.actInv(point)[2]
    if z >= 0.0:
        return False
    height, width = frame.depth.shape
    u, v = np.floor(frame.pixels(point[None])[0]).astype(int)
    if not (2 <= u < width - 2 and 2 <= v < height - 2):
        return False
    around = frame.depth[v - 2 : v + 3, u - 2 : u + 3]
    return bool(around.all() and np.median(around) > -z + margin)
