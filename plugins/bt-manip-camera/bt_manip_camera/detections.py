"""What was detected in a frame, for those who show it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .estimation import Estimate, KnownObject, sides_of
from .frame import Frame
from .segmentation import Cluster
from .tags import SeenTag


class Outline(NamedTuple):
    """A closed polygon in an image.

    Attributes:
        label: Name of an object, number of a tag, or else the size of a thing.
        pixels: Its corners, column and row [pixels].  # (n, 2)
        named: Whether it is that of an object or a tag.
    """

    label: str
    pixels: np.ndarray
    named: bool


@dataclass(frozen=True)
class Detections:
    """What was detected in a frame.

    Attributes:
        frame: The frame.
        clusters: The things on the support that are not named.
        objects: Estimated poses of the centres of objects, with what is known of them.
        tags: The tags.
    """

    frame: Frame
    clusters: Sequence[Cluster] = ()
    objects: Sequence[tuple[Estimate, KnownObject]] = ()
    tags: Sequence[SeenTag] = ()

    def outlines(self) -> Iterator[Outline]:
        """Yield the outlines of the tops of objects, of tags, and of things without a name."""
        for found, known in self.objects:
            top = known.top() @ found.T_wo.rotation.T + found.T_wo.translation
            yield Outline(known.name, self.frame.pixels(top), True)
        for tag in self.tags:
            yield Outline(f"tag {tag.number}", tag.corners, True)
        for one in self.clusters:
            xy = one.circle.corners() if one.is_round else one.rectangle.corners()
            top = np.column_stack([xy, np.full(len(xy), one.surface + one.height)])
            yield Outline(sides_of(one), self.frame.pixels(top), False)
