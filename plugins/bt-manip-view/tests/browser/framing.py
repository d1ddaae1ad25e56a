"""The camera of the page shows robots, objects and containers at any size of the window."""

import numpy as np

from .conftest import CORNERS, SIZE, Window, wait_until

SIZES = [(1400, 900), (1280, 720), (700, 900)]

SHOWN = {
    "pick_place": ("/panda", "/basket", "/cube"),
    "two_arms": ("/left", "/right", "/left_basket", "/right_basket"),
    "sort_blocks": ("/panda",),
}
"""Starts of the names of nodes that have to be seen, by tree."""

OTHERS = ("/WorldAxes", "/world", "/table", "/jog", "/planned path")
"""Starts of the names of nodes that need not be seen."""


NAMES = """
    () => Object.entries(__viserMutable.nodeRefFromName).filter(([, node]) => node).map(([n]) => n)
"""
"""Gives the names of the nodes that are there: the names of removed ones are kept."""


def check_framing(window: Window, tree: str) -> None:
    """Check the picture of a running tree at each size of the window, and pause it."""
    names: list[str] = []

    def there() -> bool:
        found = window.evaluate(NAMES)
        names[:] = [name for name in found if name.count("/") == 1]
        names[:] = [name for name in names if not name.startswith(OTHERS)]
        return all(any(name.startswith(one) for name in names) for one in SHOWN[tree])

    def paused() -> bool:
        wait_until(there, lambda: f"{names}")
        window.press("Pause")
        window.wait_for_text("s: paused")
        if not there():  # an object has gone meanwhile
            window.press("Continue")
        return window.button("Continue").count() > 0 and there()

    wait_until(paused)
    seen: list[float] = []

    def inside() -> bool:
        corners = np.abs(np.array(window.evaluate(CORNERS, names)))
        seen[:] = [float(corners.max()), len(corners)]
        return 0.6 < seen[0] < 1.0 and seen[1] > 100

    for width, height in reversed(SIZES):
        window.page.set_viewport_size({"width": width, "height": height})
        wait_until(inside, lambda: f"{window.page.viewport_size}: {seen}")
    pixels = window.scene(f"{tree}_{width}x{height}")
    assert min(len(np.unique(part)) for part in np.array_split(pixels, 3, axis=1)) > 100
    window.page.set_viewport_size(SIZE)
