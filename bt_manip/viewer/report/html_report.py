"""The HTML page of a report."""

from collections import Counter
from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

import numpy as np
from bokeh.embed import components
from bokeh.models import Range1d
from bokeh.resources import Resources

from bt_manip.recording import RecordedCycle, RecordedRun, Recording

from .plots import LABEL_WIDTH, LONGEST_REASON, ROW_HEIGHT, BarRow, Plots
from .replay import replay_html
from .thinning import LINE_SAMPLES

REASONS = 50
"""Number of different reasons of failed nodes that are listed, the most frequent ones."""

CYCLE_ROWS = 200
"""Number of cycles that are listed: the failed ones first."""

POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' blob:; worker-src blob:; "
    "style-src 'unsafe-inline'; img-src data: blob:; font-src data:; connect-src data: blob:"
)
"""What the page may load, for browsers: nothing but what is in the file."""

USED_LIMITS = ("position", "velocity", "acceleration", "torque")
"""Limits whose use is plotted; that of jerk is at its limit in most motions."""

REPORT_STYLE = """
:root{color-scheme:light}
body{font:15px/1.5 system-ui,sans-serif;color:#212529;background:#f1f3f5;margin:0}
main{max-width:1280px;margin:0 auto;padding:1.5rem}
h1{margin:0;font-size:1.7rem;overflow-wrap:anywhere}
h2{font-size:1.1rem;margin:0 0 .5rem}
section{background:#fff;border-radius:8px;padding:1rem 1.25rem;margin:1rem 0;
box-shadow:0 1px 3px #0002}
.tiles{display:flex;flex-wrap:wrap;gap:.8rem;margin:1rem 0}
.tiles div{background:#fff;border-radius:8px;padding:.6rem 1.1rem;box-shadow:0 1px 3px #0002;
flex:1 1 7rem;font-size:.85rem}
.tiles b{display:block;font-size:1.4rem;white-space:nowrap;font-weight:600;line-height:1.3}
.badge{color:#fff;border-radius:4px;padding:.1rem .5rem;font-size:.8rem;font-weight:600;
white-space:nowrap;background:#868e96}
.SUCCESS{background:#2b8a3e}.FAILURE{background:#c92a2a}
.warning{background:#fff3bf;border:1px solid #fcc419}
table{border-collapse:collapse;width:100%;font-size:.9rem}
th{text-align:left;color:#868e96;font-weight:500}
td,th{padding:.25rem .8rem .25rem 0;border-bottom:1px solid #f1f3f5;vertical-align:top;
overflow-wrap:break-word}
.narrow{color:#868e96;font-size:.85rem}
.rows{max-height:900px;overflow:auto}
.plot{display:flex}.plot>div:last-child{flex:1;min-width:0}
.names{flex:none;padding-top:5px;font-size:12px}
.names div{line-height:20px;box-sizing:border-box;white-space:nowrap;overflow:hidden;
text-overflow:ellipsis}
iframe{width:100%;height:560px;border:1px solid #dee2e6;border-radius:4px;display:block}
dl{display:grid;grid-template-columns:max-content 1fr;gap:.1rem 1.2rem;margin:0;font-size:.9rem}
dt{color:#868e96}dd{margin:0;overflow-wrap:anywhere}
"""


def html_report(recording: Recording) -> str:
    """Return the report of a recorded run as one HTML page that loads nothing.

    All text of the recording is escaped: names and reasons may hold anything.

    Raises:
        BtManipError: If it is not the recording of a run.
    """
    run = RecordedRun(recording)
    replay, rate = replay_html(recording)
    plots = Plots(run)
    nodes = [node for node in run.nodes.values() if node.intervals]
    tree = [BarRow(n.name, n.path, n.intervals, n.depth, not n.is_leaf) for n in nodes]
    drawn: list[tuple[str, Any, str]] = [("Time line of the tree", *plots.bars(tree))]
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
        _section(title, f'<div class="rows plot">{names}<div>{div}</div></div>')
        for (title, _, names), div in zip(drawn, divs, strict=True)
    ]
    title = escape(f"{recording.identity['tree']}, seed {recording.identity['seed']}")
    player = f'<iframe title="3D replay" srcdoc="{escape(replay)}"></iframe>'
    hint = (
        "All plots have the same time axis. Drag to zoom in, Ctrl and the wheel to zoom, "
        "double-click to reset. A click on a name hides its line. Dotted lines are starts of "
        "cycles."
    )
    parts = (
        _head(run),
        _warnings(run),
        _tiles(run),
        _section("Replay", player),
        _cycles(run),
        _reasons(run),
        f'<p class="narrow">{hint}</p>',
        *sections,
        _section("Run", _identity(recording)),
        f'<p class="narrow">{_resolution(run, rate, plots.gap)}</p>',
    )
    library = Resources(mode="inline", components=["bokeh"]).render_js()
    style = REPORT_STYLE + f".names{{width:{LABEL_WIDTH}px}}.names div{{height:{ROW_HEIGHT}px}}"
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{style}</style>\n{library}</head><body><main>{''.join(parts)}</main>{script}"
        "</body></html>\n"
    )


def _section(title: str, content: str) -> str:
    return f"<section><h2>{escape(title)}</h2>{content}</section>"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of cells that are HTML."""
    titles = "".join(f"<th>{escape(name)}</th>" for name in head)
    lines = ("".join(f"<td>{cell}</td>" for cell in row) for row in rows)
    return f"<table><tr>{titles}</tr>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>"


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
        '<section class="warning"><b>This recording is incomplete:</b> it was not closed at the '
        f"end of the run. It is shown up to {run.recording.end:.2f} s, its last complete chunk."
        "</section>"
    )


def _tiles(run: RecordedRun) -> str:
    ended = [cycle for cycle in run.cycles if cycle.status != "RUNNING"]
    succeeded = sum(cycle.status == "SUCCESS" for cycle in ended)
    durations = [cycle.end - cycle.start for cycle in ended]
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
    boxes = (f"<div><b>{escape(value)}</b>{escape(name)}</div>" for name, value in tiles)
    return f'<div class="tiles">{"".join(boxes)}</div>'


def _cycles(run: RecordedRun) -> str:
    head = ("cycle", "status", "start", "duration", "tracking error", "of velocity limit")
    shown = sorted(run.cycles, key=lambda cycle: cycle.status == "SUCCESS")[:CYCLE_ROWS]
    shown.sort(key=lambda cycle: cycle.start)
    more = len(run.cycles) - len(shown)
    note = f'<p class="narrow">{more} more cycles succeeded.</p>' if more else ""
    rows = [_cycle(cycle) for cycle in shown]
    table = _table((*head, "of acceleration limit", "of torque limit", "reason"), rows)
    return _section("Cycles", f'<div class="rows">{table}</div>{note}')


def _cycle(cycle: RecordedCycle) -> list[str]:
    error, use = cycle.max_tracking_error_rad, cycle.limits
    return [
        str(cycle.number),
        _badge(cycle.status),
        f"{cycle.start:.2f} s",
        f"{cycle.end - cycle.start:.2f} s",
        "" if error is None else f"{error * 1e3:.2f} mrad",
        *(f"{share:.0%}" for share in (use.velocity, use.acceleration, use.effort)),
        escape(cycle.reason),
    ]


def _reasons(run: RecordedRun) -> str:
    """Return the reasons of failed nodes and of stopped motions."""
    found = [
        (one.end, node.path, one.reason)
        for node in run.nodes.values()
        for one in node.intervals
        if one.status == "FAILURE" and one.reason
    ]
    found = sorted([*found, *run.faults])
    counts = Counter((where, reason) for _, where, reason in found)
    first: dict[tuple[str, str], float] = {}
    for time, where, reason in found:
        first.setdefault((where, reason), time)
    common = counts.most_common(REASONS)
    rows = [
        [f"{first[key]:.2f} s", str(count), escape(key[0]), escape(key[1][:LONGEST_REASON])]
        for key, count in sorted(common, key=lambda one: first[one[0]])
    ]
    if not rows:
        return ""
    more = len(counts) - len(rows)
    note = f'<p class="narrow">{more} rarer ones are not listed.</p>' if more else ""
    table = _table(("first", "times", "node or robot", "reason"), rows)
    about = '<p class="narrow">Conditions that fail are part of many trees that succeed.</p>'
    return _section("Reasons of failed nodes", f'{about}<div class="rows">{table}</div>{note}')


def _identity(recording: Recording) -> str:
    names = {"tick_s": "tick [s]", "time_step_s": "time step [s]"}
    lines = {"file": recording.path.name}
    for key, value in recording.identity.items():
        if isinstance(value, dict):
            lines |= {f"{key}: {name}": str(one) for name, one in value.items()}
        elif isinstance(value, list) and value:
            lines[key] = ", ".join(map(str, value))
        elif value not in ("", None, []):
            lines[names.get(key, key)] = str(value)
    items = (f"<dt>{escape(key)}</dt><dd>{escape(text)}</dd>" for key, text in lines.items())
    return f"<dl>{''.join(items)}</dl>"


def _resolution(run: RecordedRun, rate: float, gap: float) -> str:
    """Return what was left out to keep the file small."""
    steps = max((len(robot.t) for robot in run.robots.values()), default=0)
    parts = [f"The replay has {rate:.3g} poses per second."]
    if steps > LINE_SAMPLES:
        each = 2 * steps / LINE_SAMPLES * run.recording.identity["time_step_s"]
        parts.append(
            f"Thinned: of each {each * 1e3:.3g} ms, lines show the smallest and the largest value."
        )
    if gap:
        parts.append(f"Thinned: bars of one status less than {gap:.2g} s apart are drawn as one.")
    return " ".join(parts)
