"""A map of success rates over two quantities."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from bokeh.models import ColumnDataSource, HoverTool
from bokeh.palettes import RdYlGn11
from bokeh.plotting import figure
from bokeh.transform import linear_cmap

from bt_manip.evaluation import EpisodeResult, SuccessRate
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip_view.page.gui import is_number

from .plots import plain_text

MAP_BINS = 5
"""Number of bins of an axis with more different values, with as many episodes in each."""


class MapCell(NamedTuple):
    """A success rate where two quantities are in a bin each."""

    left: float
    right: float  # bounds of the first one
    bottom: float
    top: float  # bounds of the second one
    rate: SuccessRate


def map_axes(quantities: Mapping[str, Sequence[Any]], asked: Sequence[str]) -> Sequence[str]:
    """Return the names of two quantities that are numbers in all episodes; empty if there are none.

    They are those asked for, or else the first two.

    Raises:
        BtManipError: If one that is wanted is not among them.
    """
    names = [name for name, values in quantities.items() if all(map(is_number, values))]
    for name in asked:
        if name not in names:
            raise BtManipError(
                f"no number that differs between the episodes is called '{name}'"
                f"{did_you_mean(name, names)}"
            )
    return asked or (names[:2] if len(names) > 1 else ())


def cells(
    x: Sequence[float], y: Sequence[float], results: Sequence[EpisodeResult]
) -> list[MapCell]:
    """Return the success rates in the bins of two quantities that have episodes."""
    (columns, x_edges), (rows, y_edges) = _bins(x), _bins(y)
    by_cell: dict[tuple[int, int], list[EpisodeResult]] = {}
    for i, j, result in zip(columns, rows, results, strict=True):
        by_cell.setdefault((int(i), int(j)), []).append(result)
    return [
        MapCell(x_edges[i], x_edges[i + 1], y_edges[j], y_edges[j + 1], SuccessRate.of(here))
        for (i, j), here in sorted(by_cell.items())
    ]


def map_plot(x: str, y: str, found: Sequence[MapCell]) -> Any:
    """Return the plot of a map; the colour of a rectangle is the success rate in it."""
    plot = figure(
        height=360, sizing_mode="stretch_width", toolbar_location=None, tools=[],
        x_axis_label=plain_text(x), y_axis_label=plain_text(y),
    )  # fmt: skip
    data: dict[str, list[Any]] = {
        key: [getattr(one, key) for one in found] for key in ("left", "right", "bottom", "top")
    }
    data["share"] = [1e2 * one.rate.successes / one.rate.trials for one in found]
    data["low"], data["high"] = ([1e2 * one.rate.interval[i] for one in found] for i in range(2))
    data["episodes"] = [one.rate.trials for one in found]
    colours = linear_cmap("share", RdYlGn11[::-1], 0.0, 100.0)  # red where it fails
    drawn = plot.quad(
        left="left", right="right", bottom="bottom", top="top", source=ColumnDataSource(data),
        fill_color=colours, line_color="white",
    )  # fmt: skip
    plot.add_layout(drawn.construct_color_bar(title="success [%]"), "right")
    tips = [
        ("success", "@share{0.0} % (95 %: @low{0.0} to @high{0.0})"), ("episodes", "@episodes"),
        ("from", "@left, @bottom"), ("to", "@right, @top"),
    ]  # fmt: skip
    plot.add_tools(HoverTool(tooltips=tips, renderers=[drawn]))
    return plot


def _bins(values: Sequence[float]) -> tuple[np.ndarray, list[float]]:
    """Return the bin of each value, and the edges of the bins: quantiles, or between values."""
    different = np.unique(np.asarray(values, dtype=float))
    if len(different) > MAP_BINS:
        edges = np.unique(np.quantile(values, np.linspace(0.0, 1.0, MAP_BINS + 1)))
    else:
        middles = (different[1:] + different[:-1]) / 2
        edges = np.array([2 * different[0] - middles[0], *middles, 2 * different[-1] - middles[-1]])
    return np.clip(np.searchsorted(edges, values, "right") - 1, 0, len(edges) - 2), edges.tolist()
