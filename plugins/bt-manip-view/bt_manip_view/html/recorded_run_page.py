"""The HTML page of a recorded run."""

from collections import Counter
from html import escape
from typing import Any

import numpy as np
from bokeh.embed import components
from bokeh.models import Range1d

from bt_manip.record import CycleFigures
from bt_manip_recording import RecordedRun, Recording

from .markup import html_list, html_page, html_rows, html_section, html_tiles
from .plots import LABEL_WIDTH, LONGEST_REASON, ROW_HEIGHT, BarRow, Plots
from .replay import replay_html

SHOWN_REASONS = 50
"""Largest number of listed failure reasons, most frequent first."""

CYCLE_ROWS = 200
"""Largest number of listed cycles; failed ones are listed first."""

USED_LIMITS = ("position", "velocity", "acceleration", "torque")
"""Limits whose use is plotted; most motions reach the jerk limit."""

RESOLUTION = (
    "Of long runs, the replay has fewer poses per second, lines show the smallest and largest "
    "values of short sections, and bars of one status that are close together are merged."
)


def run_page(recording: Recording) -> str:
    """Return the self-contained HTML page of a recorded run.

    Text from the recording is escaped.

    Raises:
        BtManipError: If the recording is not one of a run.
    """
    run = RecordedRun(recording)
    replay, start = replay_html(recording)
    plots = Plots(run, start)
    nodes = [node for node in run.nodes.values() if node.intervals]
    tree = [BarRow(n.name, n.path, n.intervals, n.depth, not n.is_leaf) for n in nodes]
    drawn: list[tuple[str, Any, str]] = [("Timeline of the tree", *plots.bars(tree))]
    for name, robot in run.robots.items():
        of = f" of {name}" if len(run.robots) > 1 else ""
        fingers = [f"finger {i + 1}" for i in range(robot.grip_forces.shape[1])]
        shares = 1e2 * robot.use[:, [0, 1, 2, 4]]
        full = Range1d(start=0.0, end=max(105.0, shares.max(initial=0.0)))
        limits = plots.lines("[%]", robot.t, shares, USED_LIMITS, y_range=full)
        limits.hspan(y=100.0, line_color="#c92a2a", line_dash="dashed")
        error = plots.lines("[mrad]", robot.t, 1e3 * robot.error, robot.joints)
        drawn.append((f"Tracking error{of}", error, ""))
        drawn.append((f"Use of limits{of}, largest of all joints", limits, ""))
        if fingers:
            grip = plots.lines("[N]", robot.tick_t, robot.grip_forces, fingers)
            drawn.append((f"Grip force{of}", grip, ""))
        scale = plots.lines("", robot.tick_t, robot.speed_scale[:, None], ["speed"], height=120)
        drawn.append((f"Speed scaling{of}", scale, ""))
    if run.contacts:
        pairs = {f"{first} – {second}": one for (first, second), one in run.contacts.items()}
        contacts = plots.bars([BarRow(name, name, pairs[name]) for name in sorted(pairs)])
        drawn.append(("Contacts", *contacts))
    script, divs = components([plot for _, plot, _ in drawn])
    sections = [
        html_section(title, f'<div class="rows plot">{names}<div>{div}</div></div>')
        for (title, _, names), div in zip(drawn, divs, strict=True)
    ]
    title = f"{recording.identity['tree']}, seed {recording.identity['seed']}"
    player = f'<iframe title="3D replay" srcdoc="{escape(replay)}"></iframe>'
    hint = (
        "All plots share the time axis. Click to show a time in the replay. Drag to zoom in, "
        "Ctrl and the wheel to zoom, double-click to reset. Click a name to hide its line. "
        "Dotted lines mark the starts of cycles."
    )
    parts = (
        _head(run),
        _warnings(run),
        _tiles(run),
        html_section("Replay", player),
        _cycles(run),
        _reasons(run),
        f'<p class="narrow">{hint}</p>',
        *sections,
        html_section("Run", _identity(recording)),
        f'<p class="narrow">{RESOLUTION}</p>',
    )
    style = f".names{{width:{LABEL_WIDTH}px}}.names div{{height:{ROW_HEIGHT}px}}"
    return html_page(title, parts, script, style)


def _badge(status: str) -> str:
    text = "NOT ENDED" if status == "RUNNING" else status
    return f'<span class="badge {escape(status)}">{escape(text)}</span>'


def _head(run: RecordedRun) -> str:
    identity, statuses = run.recording.identity, {cycle.status for cycle in run.cycles}
    status = next((s for s in ("FAILURE", "RUNNING", "SUCCESS") if s in statuses), "RUNNING")
    about = f"{identity['robot']} in {identity['scene']}, seed {identity['seed']}"
    return (
        f"<h1>{escape(str(identity['tree']))} {_badge(status)}</h1>"
        f"<div>{escape(about)}, {run.recording.end:.2f} s of simulated time</div>"
    )


def _warnings(run: RecordedRun) -> str:
    if run.recording.complete:
        return ""
    return (
        '<section class="warning"><b>This recording is incomplete:</b> the run still goes '
        "on, or its process was killed. It is shown up to "
        f"{run.recording.end:.2f} s, its last complete chunk."
        "</section>"
    )


def _tiles(run: RecordedRun) -> str:
    ended = [cycle for cycle in run.cycles if cycle.status != "RUNNING"]
    succeeded = sum(cycle.status == "SUCCESS" for cycle in ended)
    durations = [cycle.duration_s for cycle in ended]
    errors = [c.max_tracking_error_rad for c in run.cycles if c.max_tracking_error_rad is not None]
    tiles = [("cycles succeeded", f"{succeeded} of {len(ended)}")]
    if durations:
        mean, shortest, longest = np.mean(durations), min(durations), max(durations)
        spread = f", {shortest:.2f} to {longest:.2f} s" if len(durations) > 1 else ""
        tiles.append((f"mean cycle time{spread}", f"{mean:.2f} s"))
    if errors:
        tiles.append(("tracking error, at most, free of contacts", f"{max(errors) * 1e3:.2f} mrad"))
    for name in ("velocity", "acceleration", "effort"):
        most = max((getattr(cycle.limits, name) for cycle in run.cycles), default=0.0)
        tiles.append((f"of the {'torque' if name == 'effort' else name} limits", f"{most:.0%}"))
    return html_tiles(tiles)


def _cycles(run: RecordedRun) -> str:
    head = ("cycle", "status", "start", "duration", "tracking error", "of velocity limit")
    shown = sorted(run.cycles, key=lambda cycle: cycle.status == "SUCCESS")[:CYCLE_ROWS]
    shown.sort(key=lambda cycle: cycle.start)
    more = len(run.cycles) - len(shown)
    note = f'<p class="narrow">{more} more cycles succeeded.</p>' if more else ""
    rows = [_cycle(cycle) for cycle in shown]
    table = html_rows((*head, "of acceleration limit", "of torque limit", "reason"), rows)
    return html_section("Cycles", f'<div class="rows">{table}</div>{note}')


def _cycle(cycle: CycleFigures) -> list[str]:
    error, use = cycle.max_tracking_error_rad, cycle.limits
    return [
        str(cycle.number),
        _badge(cycle.status),
        f"{cycle.start:.2f} s",
        f"{cycle.duration_s:.2f} s",
        "" if error is None else f"{error * 1e3:.2f} mrad",
        *(f"{share:.0%}" for share in (use.velocity, use.acceleration, use.effort)),
        escape(cycle.reason),
    ]


def _reasons(run: RecordedRun) -> str:
    """Return a table of the reasons of failed nodes and stopped motions."""
    found = [
        (one.end, node.path, one.reason)
        for node in run.nodes.values()
        for one in node.intervals
        if one.status == "FAILURE" and one.reason
    ]
    found = sorted([*found, *run.faults])
    counts = Counter((where, reason) for _, where, reason in found)
    first = {(where, reason): time for time, where, reason in reversed(found)}
    common = counts.most_common(SHOWN_REASONS)
    rows = [
        [f"{first[key]:.2f} s", str(count), escape(key[0]), escape(key[1][:LONGEST_REASON])]
        for key, count in sorted(common, key=lambda one: first[one[0]])
    ]
    if not rows:
        return ""
    more = len(counts) - len(rows)
    note = f'<p class="narrow">{more} rarer reasons are not listed.</p>' if more else ""
    table = html_rows(("first", "times", "node or robot", "reason"), rows)
    about = '<p class="narrow">Conditions that fail are part of many trees that succeed.</p>'
    return html_section("Reasons of failed nodes", f'{about}<div class="rows">{table}</div>{note}')


def _identity(recording: Recording) -> str:
    names = {"tick_s": "tick [s]", "time_step_s": "time step [s]"}
    lines = {"file": recording.path.name, "date": recording.date or "unknown"}
    for key, value in recording.identity.items():
        if isinstance(value, dict):
            lines |= {f"{key}: {name}": str(one) for name, one in value.items()}
        elif isinstance(value, list) and value:
            lines[key] = ", ".join(map(str, value))
        elif value not in ("", None, []):
            lines[names.get(key, key)] = str(value)
    return html_list(lines)
