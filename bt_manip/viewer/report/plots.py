"""The plots of a report, with Bokeh; all share their time axis."""

from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

import numpy as np
from bokeh.models import (
    BoxZoomTool,
    ColumnDataSource,
    CustomJS,
    HoverTool,
    Range1d,
    ResetTool,
    WheelZoomTool,
)  # fmt: skip
from bokeh.plotting import figure

from bt_manip.recording import Interval, RecordedRun, RobotSeries

from .thinning import merge, thin

PALETTE = ("#1971c2", "#e67700", "#2b8a3e", "#9c36b5", "#c92a2a", "#0c8599", "#5f3dc4", "#495057")
"""Colours of lines, one after the other."""

BAR_COLOURS = {
    "SUCCESS": "#40c057",
    "FAILURE": "#fa5252",
    "HALTED": "#adb5bd",
    "SKIPPED": "#adb5bd",
    "RUNNING": "#fab005",
    "": "#74c0fc",
}
"""Colours of bars by the status at their end; contacts have none."""

ROW_HEIGHT = 20
"""Height of a row of a time line [pixels]."""

TOP = 5
"""Space above the axes of a plot [pixels]."""

LONGEST_NAME = 40
"""Number of characters of a name on an axis."""

LONGEST_REASON = 200
"""Number of characters of a reason beside a bar."""

CONTACT_ROWS = 40
"""Number of pairs of bodies that are shown, those that touch longest."""

LABEL_WIDTH = 230
"""Space for the names on the left of all plots, so that their times are one below the other."""

_LIMITS = ("position", "velocity", "acceleration", "jerk", "torque")


class Plots:
    """Makes the plots of a run.

    Attributes:
        gap: Largest gap between bars of a time line that are drawn as one [s].
    """

    def __init__(self, run: RecordedRun) -> None:
        """Share a time axis.

        Args:
            run: The run.
        """
        self._run, self.gap = run, 0.0
        end = max(run.recording.end, 1e-3)
        self._range = Range1d(start=0.0, end=end, bounds=(0.0, end), min_interval=1e-3)

    def tree(self) -> tuple[Any, str]:
        """Return the time line of the nodes that ran, and the names of its rows as HTML."""
        nodes = [node for node in self._run.nodes.values() if node.intervals]
        rows, faint = [n.intervals for n in nodes], [not n.is_leaf for n in nodes]
        plot = self._bars([node.path for node in nodes], rows, faint)
        return plot, _names((node.depth, node.name, node.path) for node in nodes)

    def contacts(self) -> tuple[Any, str]:
        """Return the time line of contacts, and the names of its rows as HTML."""

        def duration(pair: tuple[str, str]) -> float:
            return sum(one.end - one.start for one in self._run.contacts[pair])

        pairs = sorted(sorted(self._run.contacts, key=duration)[-CONTACT_ROWS:])
        names = [f"{first} – {second}" for first, second in pairs]
        plot = self._bars(names, [self._run.contacts[pair] for pair in pairs])
        return plot, _names((0, name, name) for name in names)

    def error(self, robot: RobotSeries) -> Any:
        """Return the tracking errors of a robot's joints."""
        plot = self._line_figure("[mrad]")
        self._lines(plot, robot.t, robot.error.T * 1e3, robot.joints)
        return plot

    def limits(self, robot: RobotSeries) -> Any:
        """Return the use of limits of a robot: the largest of all joints."""
        plot = self._line_figure(
            "[%]", y_range=Range1d(start=0.0, end=max(105.0, 100.0 * robot.use.max()))
        )
        shown = [i for i, name in enumerate(_LIMITS) if name != "jerk"]  # it is at its limit often
        self._lines(plot, robot.t, robot.use.T[shown] * 1e2, [_LIMITS[i] for i in shown])
        plot.hspan(y=100.0, line_color="#c92a2a", line_dash="dashed")
        return plot

    def grip(self, robot: RobotSeries) -> Any:
        """Return the grip forces of a robot's fingers."""
        plot = self._line_figure("[N]")
        names = [f"finger {i + 1}" for i in range(robot.grip_forces.shape[1])]
        self._lines(plot, robot.tick_t, robot.grip_forces.T, names)
        return plot

    def speed(self, robots: dict[str, RobotSeries]) -> Any:
        """Return the speed scaling of all robots."""
        highest = max(robot.speed_scale.max(initial=1.0) for robot in robots.values())
        plot = self._line_figure("", height=120, y_range=Range1d(start=0.0, end=1.05 * highest))
        for i, (name, robot) in enumerate(robots.items()):
            self._lines(plot, robot.tick_t, robot.speed_scale[None], [name], first=i)
        return plot

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
        plot.js_on_event("doubletap", CustomJS(args={"plot": plot}, code="plot.reset.emit()"))
        return plot

    def _line_figure(self, unit: str, height: int = 220, **options: Any) -> Any:
        return self._figure(
            height=height, min_border_left=LABEL_WIDTH, y_axis_label=unit, **options
        )

    def _lines(
        self, plot: Any, t: np.ndarray, rows: np.ndarray, names: Sequence[str], first: int = 0
    ) -> None:
        for i, (row, name) in enumerate(zip(rows, names, strict=True), first):
            x, y = thin(t, row)
            plot.line(
                x.astype(np.float32), y.astype(np.float32), color=PALETTE[i % len(PALETTE)],
                line_width=1.5, legend_label=plain_text(name), name=plain_text(name),
            )  # fmt: skip
        plot.legend.click_policy = "hide"
        plot.legend.label_text_font_size = "12px"
        plot.legend.border_line_color = None
        plot.legend.spacing = 0
        plot.add_layout(plot.legend[0], "left")
        plot.add_tools(
            HoverTool(tooltips=[("", "$name"), ("t", "$x{0.000} s"), ("value", "$y{0.000}")])
        )

    def _bars(
        self, titles: Sequence[str], rows: Iterable[list[Interval]], faint: Sequence[bool] = ()
    ) -> Any:
        """Return a time line with a row for each title, some of them fainter."""
        merged, gap = merge(rows)
        self.gap = max(self.gap, gap)
        count = len(merged)
        plot = self._figure(
            frame_height=ROW_HEIGHT * count,
            min_border_left=0,
            y_range=Range1d(start=count - 0.5, end=-0.5),
        )
        plot.yaxis.visible = plot.ygrid.visible = False
        bars = [(i, one) for i, row in enumerate(merged) for one in row]
        data = {
            "row": [i for i, _ in bars],
            "title": [titles[i] for i, _ in bars],
            "start": [one.start for _, one in bars],
            "end": [one.end for _, one in bars],
            "duration": [round(one.end - one.start, 6) for _, one in bars],
            "status": [one.status for _, one in bars],
            "reason": [one.reason[:LONGEST_REASON] for _, one in bars],
            "alpha": [0.4 if faint and faint[i] else 1.0 for i, _ in bars],
            "colour": [BAR_COLOURS.get(one.status, "#adb5bd") for _, one in bars],
        }
        # What took no time is shown by the outline.
        drawn = plot.hbar(
            y="row", left="start", right="end", height=0.7, source=ColumnDataSource(data),
            fill_color="colour", line_color="colour", line_width=2, alpha="alpha",
        )  # fmt: skip
        tips = [("", "@title"), ("status", "@status"), ("from", "@start{0.000} s")]
        tips += [("for", "@duration{0.000} s"), ("reason", "@reason")]
        plot.add_tools(HoverTool(tooltips=tips, renderers=[drawn]))
        return plot


def _names(rows: Iterable[tuple[int, str, str]]) -> str:
    """Return the names beside the rows of a time line: depth, name and hint of each."""
    lines = (
        f'<div title="{escape(hint)}" style="padding-left:{0.7 * depth:.1f}em">{escape(name)}</div>'
        for depth, name, hint in rows
    )
    return f'<div class="names">{"".join(lines)}</div>'


def plain_text(text: str) -> str:
    """Return a short text that Bokeh draws as it is: ``$$`` would start a formula."""
    short = text if len(text) <= LONGEST_NAME else f"{text[: LONGEST_NAME - 1]}…"
    return short.replace("$", "$\u200b").replace("\\", "\\\u200b")
