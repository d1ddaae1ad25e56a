"""The HTML page of an evaluation or a sweep."""

import json
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any, NamedTuple

import numpy as np
from bokeh.embed import components
from bokeh.models import ColumnDataSource, HoverTool, Range1d
from bokeh.plotting import figure

from bt_manip.evaluation import EpisodeResult, SuccessRate

from .markup import html_list, html_page, html_rows, html_section, html_tiles
from .plots import LONGEST_REASON, PALETTE, plain_text
from .success_map import cells, map_axes, map_plot

MAX_VALUES = 12
"""Number of different numbers that are drawn one by one; more are drawn in bins."""

BINS = 8
"""Number of bins, with as many episodes in each."""

MAX_PLOTS = 40
"""Number of quantities that are drawn."""

LISTED_FAILURES = 50
"""Number of failures that are listed, the most frequent ones."""


class RateAt(NamedTuple):
    """A success rate where a quantity has a value, or is in a bin."""

    x: Any  # the value, or the mean of the bin
    label: str  # the value or the bounds of the bin
    rate: SuccessRate


def results_page(
    identity: Mapping[str, Any], results: Sequence[EpisodeResult], axes: Sequence[str] = ()
) -> str:
    """Return the page of an evaluation, HTML that loads nothing.

    It draws the success rate against each varied parameter and each sampled quantity, and a map of
    two of them.

    Args:
        identity: What the results depend on.
        results: The results.
        axes: Names of the two quantities of the map; default: the first two that are numbers.

    Raises:
        BtManipError: If no numbers of such a name differ between episodes.
    """
    total = SuccessRate.of(results)
    found = quantities(identity["points"], results)
    drawn = {}
    across = map_axes(found, axes)
    if across:
        x, y = across
        drawn[f"{x} and {y}"] = map_plot(x, y, cells(found[x], found[y], results))
    for name, values in list(found.items())[:MAX_PLOTS]:
        drawn[name] = _plot(name, rates_by_value(values, results))
    script, divs = components(list(drawn.values())) if drawn else ("", ())
    low, high = total.interval
    times = [one.duration_s for one in results] or [0.0]
    wall = sum(one.wall_s for one in results)
    tiles = [
        ("episodes", str(total.trials)),
        (f"succeeded, 95 %: {low:.2%} to {high:.2%}", f"{total.successes / total.trials:.2%}")
        if total.trials
        else ("succeeded", "-"),
        ("mean simulated time", f"{np.mean(times):.2f} s"),
        ("real time for each core", f"{sum(times) / wall if wall else 0.0:.1f} x"),
    ]
    failed = [
        [escape(one.node), str(one.count), str(one.first), escape(one.reason[:LONGEST_REASON])]
        for one in total.failures()[:LISTED_FAILURES]
    ]
    failures = html_rows(("failed node", "episodes", "first episode", "reason"), failed)
    rows = [
        [escape(one.node), one.kind, str(one.total), str(one.episodes), str(one.successes)]
        for one in total.recoveries()[:LISTED_FAILURES]
    ]
    recoveries = html_rows(("node", "", "times", "episodes", "succeeded"), rows)
    hint = "Bars are 95 % intervals. They are wide where a value has few episodes."
    lines = {key: json.dumps(value) for key, value in identity.items() if key != "points"}
    title = f"{identity['tree']}, seed {identity['seed']}"
    parts = [
        f"<h1>{escape(title)}</h1>",
        html_tiles(tiles),
        *(f"<p>{escape(line)}</p>" for line in total.use.sentences("episodes")),
        html_section("Failures", f'<div class="rows">{failures}</div>') if failed else "",
        html_section("Retries and rescues", f'<div class="rows">{recoveries}</div>')
        if rows
        else "",
        f'<p class="narrow">{hint}</p>' if drawn else "",
        *(html_section(name, div) for name, div in zip(drawn, divs, strict=True)),
        html_section("Evaluation", html_list(lines)),
    ]
    return html_page(title, parts, script)


def quantities(
    points: Sequence[Mapping[str, Any]], results: Sequence[EpisodeResult]
) -> dict[str, list[Any]]:
    """Return what differs between episodes, by name: a value for each result, None without one.

    These are the varied parameters, then what nodes drew and the randomized quantities; of a list
    or a pose, each number is one.
    """
    rows = []
    for one in results:
        row = dict(points[one.point])
        for path, ports in json.loads(one.drawn).items():
            row |= _numbers(path, ports)
        for kind, things in json.loads(one.randomized).items():
            row |= _numbers(f"scene.{kind}", things)
        rows.append(row)
    names = dict.fromkeys(name for row in rows for name in row)
    columns = {name: [row.get(name) for row in rows] for name in names}
    return {name: one for name, one in columns.items() if len(set(map(str, one))) > 1}


def _numbers(name: str, value: Any) -> dict[str, Any]:
    """Return the numbers of nested objects and lists, by name."""
    if isinstance(value, Mapping):
        pairs = [(f"{name}.{key}", one) for key, one in value.items()]
    elif isinstance(value, list):
        pairs = [(f"{name}[{i}]", one) for i, one in enumerate(value)]
    else:
        return {name: value}
    found: dict[str, Any] = {}
    for key, one in pairs:
        found |= _numbers(key, one)
    return found


def rates_by_value(values: Sequence[Any], results: Sequence[EpisodeResult]) -> list[RateAt]:
    """Return the success rate at each value, or in bins where there are many numbers."""
    pairs = [(v, r) for v, r in zip(values, results, strict=True) if v is not None]
    numeric = all(isinstance(v, int | float) for v, _ in pairs)
    if numeric:
        pairs.sort(key=lambda pair: float(pair[0]))
    else:
        pairs = [(str(v), r) for v, r in pairs]
    different = dict.fromkeys(v for v, _ in pairs)
    if not numeric or len(different) <= MAX_VALUES:
        return [RateAt(v, str(v), SuccessRate.of(r for w, r in pairs if w == v)) for v in different]
    rates = []
    for bin_ in np.array_split(np.arange(len(pairs)), BINS):
        here = [pairs[i] for i in bin_]
        label = f"{here[0][0]:.4g} to {here[-1][0]:.4g}"
        x = float(np.mean([v for v, _ in here]))
        rates.append(RateAt(x, label, SuccessRate.of(r for _, r in here)))
    return rates


def _plot(name: str, rates: Sequence[RateAt]) -> Any:
    texts = any(isinstance(one.x, str) for one in rates)
    xs = [plain_text(one.x) if texts else one.x for one in rates]
    range_: dict[str, Any] = {"x_range": xs} if texts else {}
    plot = figure(
        height=240, sizing_mode="stretch_width", toolbar_location=None, tools=[],
        y_range=Range1d(start=0.0, end=105.0), y_axis_label="success [%]",
        x_axis_label=plain_text(name), **range_,
    )  # fmt: skip
    shares = [1e2 * one.rate.successes / one.rate.trials for one in rates]
    bounds = [one.rate.interval for one in rates]
    data = {
        "x": xs, "share": shares, "low": [1e2 * low for low, _ in bounds],
        "high": [1e2 * high for _, high in bounds], "label": [one.label for one in rates],
        "episodes": [one.rate.trials for one in rates],
    }  # fmt: skip
    source = ColumnDataSource(data)
    plot.segment(x0="x", x1="x", y0="low", y1="high", source=source, color=PALETTE[0], line_width=2)
    if not texts:
        plot.line("x", "share", source=source, color=PALETTE[0], alpha=0.4)
    dots = plot.scatter("x", "share", source=source, color=PALETTE[0], size=8)
    tips = [("", "@label"), ("success", "@share{0.0} %"), ("episodes", "@episodes")]
    plot.add_tools(HoverTool(tooltips=tips, renderers=[dots]))
    return plot
