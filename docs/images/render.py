"""Draw the picture and the animation of pick_place anew.

    python docs/images/render.py [FOLDER]

The animation is that of ``bt-manip run pick_place --seed 3 --record "pick_place.gif size=800x500
fps=12.5 overlay=yes"``. Where there is no display, MUJOCO_GL=egl or MUJOCO_GL=osmesa says what to
draw with.
"""

import sys
from pathlib import Path

import numpy as np

from bt_manip.models import bundled_path
from bt_manip.plugins import load_plugins
from bt_manip.runner import Run, RunRequest, Station, find_tree, prepare
from bt_manip.viewer import NoOpenGLError, render, write_png
from bt_manip_view import VideoRecorder

HERE = Path(__file__).resolve().parent
SEED = 3  # the cube lies on the near side, and its shadow falls on the table


def pick_place(seed: int = SEED) -> Run:
    """Prepare a run of the tree."""
    tree = find_tree(str(bundled_path("pick_place.xml", "trees")), {})
    return prepare(RunRequest(tree, seed=seed), load_plugins().parts)


def pick_place_in_the_middle(seed: int = SEED) -> Station:
    """Run pick_place until the cube is on its way, a hand's breadth from the basket's rim."""
    run = pick_place(seed)
    cell, gripper = run.station.cell, run.station.gripper

    def on_its_way() -> bool:
        if "cube" not in gripper.held:
            return False
        way = cell.pose("basket").translation - cell.pose("cube").translation
        return bool(np.linalg.norm(way[:2]) < 0.21)

    run.execute(stop=on_its_way)
    return run.station


def main() -> None:
    """Draw both."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE
    file, animation = folder / "pick_place.png", folder / "pick_place.gif"
    try:
        picture = render(pick_place_in_the_middle().cell)
    except NoOpenGLError as error:
        sys.exit(f"Error: {error}")
    write_png(file, picture)
    recorder = VideoRecorder(animation, size="800x500", fps=12.5, overlay=True)
    pick_place().execute([recorder])
    for one in (file, animation):
        print(f"{one}: {one.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
