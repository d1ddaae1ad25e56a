"""Frames of a model and its nested models, and their relative poses.

SDF 1.7 and later: links, joints, frames and nested models are frames; each has a pose relative to
another frame, whose name is looked up in its own model (``inner::link`` refers to a nested model).
http://sdformat.org/tutorials?tut=pose_frame_semantics
"""

from collections.abc import Iterator
from dataclasses import dataclass

import pinocchio as pin

from bt_manip.exceptions import did_you_mean
from bt_manip_fuel.sdf.reader import Element, SdfReader

MODEL = "__model__"
WORLD = "world"
SEPARATOR = "::"
MAX_FRAMES = 5_000
"""Maximum number of frames in all nested models, as nested includes grow exponentially."""


@dataclass(frozen=True)
class Frame:
    """A frame of the document.

    Attributes:
        kind: ``"model"``, ``"link"``, ``"joint"`` or ``"frame"``.
        element: Its element in the document.
        scope: Prefix of the names in its scope, such as ``"arm::"``.
        T: Its pose relative to another frame.
        relative_to: Name of the other frame; empty for the default of its kind.
        attached_to: For frames, the frame to which they are fixed.
        placement: For models, the frame that is at the pose.
    """

    kind: str
    element: Element
    scope: str
    T: pin.SE3
    relative_to: str = ""
    attached_to: str = ""
    placement: str = ""


class Scopes:
    """All frames of a model by their full names, and their poses."""

    def __init__(self, reader: SdfReader) -> None:
        self._reader = reader
        self._frames: dict[str, Frame] = {}
        self._busy: list[tuple[str, str]] = []

    def add(self, name: str, frame: Frame) -> None:
        """Add a frame by its full name.

        Raises:
            ModelError: If the name is taken or invalid.
        """
        whole = name.removesuffix(SEPARATOR + MODEL)
        own = whole.rpartition(SEPARATOR)[2]
        if own in (WORLD, "") or "/" in own:
            raise self._reader.error(frame.element, f"'{own}' cannot be a name")
        if whole in self._frames or whole + SEPARATOR + MODEL in self._frames:
            raise self._reader.error(frame.element, f"the name '{own}' is used twice")
        if len(self._frames) >= MAX_FRAMES:
            raise self._reader.error(frame.element, f"more than {MAX_FRAMES} links and frames")
        self._frames[name] = frame

    def of_kind(self, kind: str) -> Iterator[tuple[str, Frame]]:
        """Yield the frames of a kind, in the order of the document."""
        return ((name, f) for name, f in self._frames.items() if f.kind == kind)

    def whole_name(self, scope: str, name: str, element: Element) -> str:
        """Return the full name of a frame, given its name in a scope.

        Raises:
            ModelError: If there is no such frame.
        """
        if name == WORLD:
            return WORLD
        for candidate in (scope + name, scope + name + SEPARATOR + MODEL):
            if candidate in self._frames:
                return candidate
        known = [n.removeprefix(scope) for n in self._frames if n.startswith(scope)]
        near = did_you_mean(name, known)
        raise self._reader.error(element, f"there is no frame '{name}' in the model{near}")

    def pose(self, name: str, origin: str = MODEL) -> pin.SE3:
        """Return the pose of a frame relative to another one that it depends on.

        Raises:
            ModelError: If frames are relative to each other in a cycle.
        """
        if name in (origin, WORLD):
            return pin.SE3.Identity()
        frame = self._frames[name]
        if (name, origin) in self._busy:
            raise self._reader.error(frame.element, f"'{name}' is relative to itself")
        if name == MODEL:
            raise self._reader.error(frame.element, "a placement frame outside of its model")
        self._busy.append((name, origin))
        T = self.pose(self._base(frame), origin) * frame.T
        if frame.placement:
            inner = self._inner(name, frame)
            T = T * self.pose(inner, name).inverse()
        self._busy.pop()
        return T

    def root_placement(self) -> pin.SE3:
        """Return the pose of the model's placement frame."""
        frame = self._frames[MODEL]
        return self.pose(self._inner(MODEL, frame)) if frame.placement else pin.SE3.Identity()

    def local(self, link: str, pose: Element | None) -> pin.SE3:
        """Return the pose of a visual, collision or inertial in its link.

        Raises:
            ModelError: If it is none.
        """
        T = self._reader.pose(pose)
        if pose is None or not pose.get("relative_to"):
            return T
        base = self.whole_name(self._frames[link].scope, pose.get("relative_to", ""), pose)
        return self.pose(link).inverse() * self.pose(base) * T

    def link_of(self, name: str) -> str:
        """Return the link that a frame moves with, or the world.

        Raises:
            ModelError: If there is none.
        """
        for _ in range(len(self._frames) + 1):
            if name == WORLD:
                return WORLD
            frame = self._frames[name]
            if frame.kind == "link":
                return name
            if frame.kind == "joint":
                name = self._named(frame, self._reader.text(frame.element, "child"))
            elif frame.kind == "frame":
                name = self._named(frame, frame.attached_to or MODEL)
            else:
                inside = name.removesuffix(MODEL)
                canonical = frame.element.get("canonical_link", "")
                if canonical:
                    name = self.whole_name(inside, canonical, frame.element)
                else:
                    links = [n for n, _ in self.of_kind("link") if n.startswith(inside)]
                    if not links:
                        raise self._reader.error(frame.element, "a model without links")
                    name = links[0]
        raise self._reader.error(frame.element, "frames are attached to each other in a cycle")

    def _named(self, frame: Frame, name: str) -> str:
        return self.whole_name(frame.scope, name, frame.element)

    def _inner(self, name: str, frame: Frame) -> str:
        return self.whole_name(name.removesuffix(MODEL), frame.placement, frame.element)

    def _base(self, frame: Frame) -> str:
        """Return the reference frame of a frame's pose."""
        if frame.relative_to:
            return self._named(frame, frame.relative_to)
        if frame.kind == "joint":
            return self._named(frame, self._reader.text(frame.element, "child"))
        if frame.kind == "frame" and frame.attached_to:
            return self._named(frame, frame.attached_to)
        return frame.scope + MODEL
