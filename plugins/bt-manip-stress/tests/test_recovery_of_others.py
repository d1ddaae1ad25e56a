"""The bundled trees recover from what disturbs fast motions or single attempts."""

import pytest

from bt_manip_stress import StressTester, plan_episodes


@pytest.mark.parametrize(
    ("tree", "fault", "phase"),
    [
        pytest.param("two_arms", "sensor_delay", "left/the second/Hover", marks=pytest.mark.soak),
        ("pick_place_cluttered", "sensor_noise", "the second/attempt/Drop"),
    ],
)
def test_a_tree_recovers_from(tree, fault, phase):
    tester = StressTester(tree)
    (phase,) = [one.name for one in tester.phases() if one.name.startswith(f"{phase}::")]
    (episode,) = plan_episodes(tester, 1, [fault], [phase])
    result = tester.run(episode)
    assert (result.outcome, result.reason, result.next_reason) == ("recovered", "", "")
