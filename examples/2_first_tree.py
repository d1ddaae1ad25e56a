"""The same pick as a behaviour tree: behaviours in a sequence, linked by a blackboard key.

Run it as a script, or let the command line show it: bt-manip run examples/2_first_tree.py:pick
"""

from bt_manip import build_station
from bt_manip.behaviours import Drop, Grasp, Hover, IsIn, Lift, Reach, SpawnObject
from bt_manip.bt import RetryUntilSuccessful, Sequence, Tree


def pick(force: float = 50.0) -> Tree:
    """Add a cube to the table and pick it; bt-manip run ... --set force=30 sets the argument."""
    root = Sequence(
        "pick and drop",
        SpawnObject(object="{cube}"),  # writes the name of the object to the key "cube"
        RetryUntilSuccessful(
            "try twice",
            Sequence(
                "pick",
                Hover(object="{cube}", height=0.15),  # reads the key
                Reach(object="{cube}"),
                Grasp(object="{cube}", force=force),
                Lift(height=0.3),
            ),
            num_attempts=2,
        ),
        Drop(container="basket"),
    )
    # A run succeeds only if the goal holds in the physics, whatever the tree returned.
    return Tree(root, goal=IsIn(object="{cube}", container="basket"))


def main() -> None:
    """Run the tree twice: as it is, and with a force beyond the gripper's."""
    station = build_station(seed=0)
    for force in (50.0, 500.0):
        result = station.run(pick(force))
        print(f"{force:.0f} N, after {station.cell.time:.2f} s: {result}")


if __name__ == "__main__":
    main()
