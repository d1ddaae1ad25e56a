"""Bokeh plots of a page, with a common time axis."""

from collections.abc import Sequence
from html import escape
from typing import Any, NamedTuple

import numpy as np
from bokeh.models import (
    BoxZoomTool,
    ColumnDataSource,
    CustomJS,
    HoverTool,
    Range1d,
    ResetTool,
    WheelZoomTool,
)
from bokeh.plotting import figure

from bt_manip.record import Interval
from bt_manip_recording import RecordedRun

from .thinning import merge, thin

PALETTE = ("#1971c2", "#e67700", "#2b8a3e", "#9c36b5", "#c92a2a", "#0c8599", "#5f3dc4", "#495057")
"""Colours of lines, in this order."""

BAR_COLOURS = {
    "SUCCESS": "#40c057",
    "FAILURE": "#fa5252",
    "HALTED": "#adb5bd",
    "SKIPPED": "#adb5bd",
    "RUNNING": "#fab005",
    "": "#74c0fc",
}
"""Colours of bars by final status; the empty status is that of contacts."""

ROW_HEIGHT = 20
"""Height of a row of a timeline [pixels]."""

TOP = 5
"""Space above the axes of a plot [pixels]."""

LONGEST_REASON = 200
"""Largest number of characters of a reason."""

LABEL_WIDTH = 230
"""Width of the names left of each plot, which aligns the time axes [pixels]."""


SEEK = """
const player = document.querySelector("iframe").contentDocument;
player.querySelector("button:has(.tabler-icon-player-pause-filled)")?.click();
const box = player.querySelector("input"), view = player.defaultView;
const value = Object.getOwnPropertyDescriptor(view.HTMLInputElement.prototype, "value");
box.focus({ preventScroll: true });
value.set.call(box, Math.max(cb_obj.x - start, 0).toFixed(3));
box.dispatchEvent(new view.Event("input", { bubbles: true }));
box.dispatchEvent(new view.KeyboardEvent("keydown", { key: "Enter", bubbles: true }));
box.blur();
"""
"""Moves the replay to the clicked time, by the time field of viser's player."""


class BarRow(NamedTuple):
    """A row of a timeline."""

    name: str
    hint: str
    intervals: list[Interval]
    depth: int = 0
    faint: bool = False


class Plots:
    """Makes the plots of a run.

    Args:
        run: The run.
        start: Simulated time at the start of the replay [s].
    """

    def __init__(self, run: RecordedRun, start: float) -> None:
        self._run, self._start = run, start
        end = max(run.recording.end, 1e-3)
        self._range = Range1d(start=0.0, end=end, bounds=(0.0, end), min_interval=1e-3)

    def lines(
        self, unit: str, t: np.ndarray, columns: np.ndarray, names: Sequence[str], **options: Any
    ) -> Any:
        """Return a plot over time [s] with a line for each named column; `options` are Bokeh's."""
        # t: (n,), columns: (n, k)
        options = {"height": 220, "min_border_left": LABEL_WIDTH, **options}
        plot = self._figure(y_axis_label=unit, **options)
        for i, name in enumerate(names):
            x, y = thin(np.column_stack([t, columns[:, i]])).T.astype(np.float32)
            plot.line(
                x, y, color=PALETTE[i % len(PALETTE)], line_width=1.5,
                legend_label=plain_text(name), name=plain_text(name),
            )  # fmt: skip
        plot.legend.click_policy = "hide"
        plot.legend.label_text_font_size = "12px"
        plot.legend.border_line_color = None
        plot.legend.spacing = 0
        plot.add_layout(plot.legend[0], "left")
        plot.add_tools(
            HoverTool(tooltips=[("", "$name"), ("t", "$x{0.000} s"), ("value", "$y{0.000}")])
        )
        return plot

    def bars(self, rows: Sequence[BarRow]) -> tuple[Any, str]:
        """Return a timeline, and the names of its rows as HTML."""
        merged = merge(row.intervals for row in rows)
        plot = self._figure(
            frame_height=ROW_HEIGHT * len(rows), min_border_left=0,
            y_range=Range1d(start=len(rows) - 0.5, end=-0.5),
        )  # fmt: skip
        plot.yaxis.visible = plot.ygrid.visible = False
        bars = [(i, one) for i, intervals in enumerate(merged) for one in intervals]
        data = {
            "row": [i for i, _ in bars],
            "hint": [rows[i].hint for i, _ in bars],
            "start": [one.start for _, one in bars],
            "end": [one.end for _, one in bars],
            "duration": [round(one.end - one.start, 6) for _, one in bars],
            "status": [one.status for _, one in bars],
            "reason": [one.reason[:LONGEST_REASON] for _, one in bars],
            "alpha": [0.4 if rows[i].faint else 1.0 for i, _ in bars],
            "colour": [BAR_COLOURS.get(one.status, "#adb5bd") for _, one in bars],
        }
        # What took no time is shown by the outline.
        drawn = plot.hbar(
            y="row", left="start", right="end", height=0.7, source=ColumnDataSource(data),
            fill_color="colour", line_color="colour", line_width=2, alpha="alpha",
        )  # fmt: skip
        tips = [("", "@hint"), ("status", "@status"), ("from", "@start{0.000} s")]
        tips += [("for", "@duration{0.000} s"), ("reason", "@reason")]
        plot.add_tools(HoverTool(tooltips=tips, renderers=[drawn]))
        names = (
            f'<div title="{escape(row.hint)}" style="padding-left:{0.7 * row.depth:.1f}em">'
            f"{escape(row.name)}</div>"
            for row in rows
        )
        return plot, f'<div class="names">{"".join(names)}</div>'

    # Internal

    def _figure(self, **options: Any) -> Any:
        wheel = WheelZoomTool(dimensions="width", modifiers={"ctrl": True})
        plot = figure(
            x_range=self._range, tools=[BoxZoomTool(dimensions="width"), wheel, ResetTool()],
            active_scroll=wheel, toolbar_location=None,
            sizing_mode="stretch_width", min_border_right=20, min_border_top=TOP, **options,
        )  # fmt: skip
        plot.xaxis.axis_label = "simulated time [s]"
        plot.outline_line_color = None
        plot.grid.grid_line_color = "#f1f3f5"
        plot.axis.axis_line_color = plot.axis.major_tick_line_color = "#ced4da"
        plot.axis.minor_tick_line_color = None
        plot.axis.axis_label_text_font_style = "normal"
        starts = [cycle.start for cycle in self._run.cycles[1:]]
        if starts:
            plot.vspan(x=starts, line_color="#868e96", line_dash="dotted")
        plot.js_on_event("tap", CustomJS(args={"start": self._start}, code=SEEK))
        plot.js_on_event("doubletap", CustomJS(args={"plot": plot}, code="plot.reset.emit()"))
        return plot


def plain_text(text: str) -> str:
    """Escape a text for Bokeh, where ``$$`` would start a formula."""
    return text.replace("$", "$\u200b").replace("\\", "\\\u200b")
