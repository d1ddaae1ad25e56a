"""What is true of a held object."""

from bt_manip.runner import Station


def check_held(station: Station) -> None:
    """Check that all know that "thing" is held, and that a state continues to the last bit."""
    world = station.arm.world
    world.refresh()
    assert world.held == "thing" and not world.collisions(station.robot.q)
    summary = station.cell.contact_monitor.summary()
    assert summary.unexpected == () and summary.held == ("thing",)
    state, ends = station.get_state(), []
    for _ in range(2):
        station.cell.step(100)
        ends.append(station.cell.state_bytes())
        station.set_state(state)
    assert ends[0] == ends[1]
