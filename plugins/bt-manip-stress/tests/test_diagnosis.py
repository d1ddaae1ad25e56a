"""Reasons of faults of the arm name the cause."""

import re

import pytest

from bt_manip.runner import RunObserver, prepare, request_of

pytestmark = pytest.mark.usefixtures("shared_stations")


class Faults(RunObserver):
    """Keeps the faults of the arm."""

    def run_started(self, run):
        self.arm, self.found = run.station.arm, []

    def after_tick(self):
        if self.arm.fault and self.arm.fault not in self.found:
            self.found.append(self.arm.fault)


@pytest.mark.parametrize(("node", "mass"), [("Grasp", 3.2), ("Drop", 1.0)])
def test_payload_that_is_too_heavy_is_named_with_its_mass(parts, node, mass):
    modifiers = {"fault": (f"heavy at={node} mass={mass}",)}
    faults = Faults()
    run = prepare(request_of("pick_place", parts, modifiers=modifiers), parts)
    run.execute([faults], stop=lambda: bool(faults.found))
    found = re.match(r"the payload weighs about (\S+) kg, 0.057 kg were assumed", faults.found[0])
    assert found, faults.found
    assert float(found.group(1)) == pytest.approx(mass, rel=0.15)
