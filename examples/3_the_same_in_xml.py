"""The same tree as a BehaviorTree.CPP file; editing the file changes the task.

Without Python: bt-manip run examples/3_first_tree.xml
"""

from pathlib import Path

from bt_manip import build_station
from bt_manip.behaviours import Drop, Grasp, Hover, IsIn, Lift, Reach, SpawnObject
from bt_manip.bt import BehaviourRegistry, load_tree, parse_tree
from bt_manip.exceptions import TreeError

FILE = Path(__file__).with_name("3_first_tree.xml")


def main() -> None:
    """Run the file as it is, then with a gentler grasp, then with a typing error."""
    station = build_station(seed=0)
    # The behaviours available to the file; every registry includes the nodes of the language.
    behaviours = BehaviourRegistry([SpawnObject, Hover, Reach, Grasp, Lift, Drop, IsIn])

    tree = load_tree(FILE, behaviours, clock=station.clock)
    print(f"as it is: {station.run(tree)}, after {station.cell.time:.2f} s simulated")

    text = FILE.read_text()
    gentle = text.replace('force="50.0"', 'force="20.0"')
    tree = parse_tree(gentle, behaviours, clock=station.clock)
    print(f"with 20 N: {station.run(tree)}")

    try:
        parse_tree(text.replace("<Reach", "<Raech"), behaviours, file=FILE.name)
    except TreeError as error:
        print(f"with a typing error: {error}")


if __name__ == "__main__":
    main()
