"""The kinds of actions by name."""

from bt_manip.exceptions import BtManipError, did_you_mean

from .actions import ActionKind
from .arm_actions import CartesianDeltas, JointTargets, JointTorques
from .episodes import Episodes
from .subtree_choice import SubtreeChoice

ACTIONS: dict[str, type[ActionKind]] = {
    one.kind: one for one in (JointTorques, JointTargets, CartesianDeltas, SubtreeChoice)
}
"""The kinds of actions by name."""


def action_kind(name: str, episodes: Episodes) -> ActionKind:
    """Return a kind of actions by name.

    Raises:
        BtManipError: If there is none of that name.
    """
    if name not in ACTIONS:
        raise BtManipError(f"no actions are called '{name}'{did_you_mean(name, ACTIONS)}")
    return ACTIONS[name](episodes)
