"""The report is JSON with the agreed names."""

import json
from dataclasses import replace

from bt_manip.record.report.run_report import LeafTime, LeafUse, versions

from .test_report_file import report


def test_run_and_cycle_have_the_agreed_keys():
    written = json.loads(replace(report(1), versions=versions()).to_json())
    (cycle,) = written["cycles"]
    assert {
        "tree", "seed", "status", "cycles", "simulated_s", "wall_s", "real_time_factor",
        "state_digest", "versions",
    } <= set(written)  # fmt: skip
    assert written["versions"]["mujoco"][0].isdigit()
    assert "python" in written["versions"]
    assert {
        "status", "object", "placed", "duration_s", "phases", "grip_force_n",
        "max_tracking_error_rad", "limits", "saturated_steps", "unexpected_contacts",
    } <= set(cycle)  # fmt: skip
    assert cycle["limits"] == {
        "position": 0.5, "velocity": 0.6, "acceleration": 0.7, "jerk": 0.8, "effort": 0.9,
    }  # fmt: skip
    assert cycle["unexpected_contacts"] == [["panda/hand", "table"]]
    assert cycle["phases"] == [
        {
            "behaviour": "Grasp", "name": "grasp it", "status": "FAILURE",
            "reason": "the fingers met", "start_s": 1.5, "duration_s": 0.25,
        }
    ]  # fmt: skip


def test_the_use_of_leaves_is_summed_over_cycles():
    use = LeafUse()
    use.add({"RunPolicy": LeafTime(0.5, ("pushed by 3.5 N",))}, 4.0)
    use.add({"RunPolicy": LeafTime(0.0, ("not finite", "pushed by 4.5 N"))}, 2.0)
    use.add({"RunPolicy": LeafTime(1.0)}, 2.0)
    assert use.sentences("cycles") == [
        "RunPolicy ran in 2 of 3 cycles, for 50.0% of the time: 2 x pushed by 3.5 N; "
        "1 x not finite."
    ]
    assert LeafUse().sentences("cycles") == []
