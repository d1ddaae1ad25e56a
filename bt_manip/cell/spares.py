"""Things that were taken out of an arena, for when the same ones are wanted again."""

from collections.abc import Mapping
from typing import Any

from bt_manip.cell.physics.attachment import Attachment
from bt_manip.cell.physics.edit_tracker import EditTracker


class Spares:
    """Keeps what was taken out last, and gives it back where it would be made anew.

    What was ever changed, or stands elsewhere by now, is not given back.

    Attributes:
        limit: How many things are kept; none at first.
    """

    def __init__(self, changes: EditTracker) -> None:
        """Begin with nothing kept.

        Args:
            changes: Tells what was changed.
        """
        self.limit = 0
        self._changes = changes
        self._kept: list[tuple[dict[str, Any], Attachment]] = []

    def keep(self, name: str, placement: Attachment) -> None:
        """Keep what has just been taken out."""
        if self.limit:
            self._kept.append((placement.describe(name), placement))
            del self._kept[: -self.limit]

    def take(self, entry: Mapping[str, Any]) -> Attachment | None:
        """Give back what was described, if that is kept."""
        for spare in self._kept:
            description, placement = spare
            entity = placement.entity
            usable = entity.parent is None and self._changes.none(entity.mjcf_model)
            if description == entry and usable:
                self._kept.remove(spare)
                return placement
        return None
