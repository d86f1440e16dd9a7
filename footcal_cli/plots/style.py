"""How every figure looks: one palette, one size, axes with units."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure


CELL_COLOURS = (
    "#0072B2", "#AE5831", "#186E5E", "#D55E00", "#5283FF", "#CC79A7", "#5A2B0F", "#580999",
)  # fmt: skip
"""One per cell or leg, black is the truth's. All stand out from white by 3 : 1 (WCAG AA) and from
each other for colour-blind readers, too; made by a search that started from Okabe and Ito's."""
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<")
"""One per cell or leg besides its colour."""
MOST_POINTS = 4000
"""More points than this no figure of this width shows."""
BEFORE, AFTER, REFERENCE, BAD = "#868e99", "#0072B2", "#1b1f24", "#D55E00"
WIDTH_IN = 8.5
_EDGE_IN = 0.08


def new_figure(height_in: float, width_in: float = WIDTH_IN) -> Figure:
    """An empty figure that belongs to no window."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    # titles keep off the frame
    layout = ConstrainedLayoutEngine(h_pad=_EDGE_IN, w_pad=_EDGE_IN)
    figure = Figure(figsize=(width_in, height_in), layout=layout)
    FigureCanvasAgg(figure)
    return figure


def tidy(axes: Axes, title: str = "", x: str = "", y: str = "") -> None:
    """Title, labels, light grid, no box; numbers that are whole by themselves: no 1e6 above."""
    from matplotlib.ticker import ScalarFormatter

    for axis in (axes.xaxis, axes.yaxis):
        form = axis.get_major_formatter()
        if isinstance(form, ScalarFormatter):
            form.set_useOffset(False)
            form.set_powerlimits((-5, 9))
    axes.set_title(title, loc="left", fontsize=10)
    axes.set_xlabel(x, fontsize=9)
    axes.set_ylabel(y, fontsize=9)
    axes.tick_params(which="both", labelsize=8)
    axes.grid(color="#e3e6ea", linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def legend_below(figure: Figure, columns: int = 5) -> None:
    """One legend of all panels below the figure, off the curves; each label once."""
    named = {
        label: handle
        for axes in figure.axes
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    figure.legend(
        list(named.values()), list(named), loc="outside lower center", fontsize=8, frameon=False,
        ncols=min(len(named), columns) or 1,
    )  # fmt: skip


def log_axis(axes: Axes) -> None:
    """A logarithmic x axis with plain numbers: 0.04, not 4 × 10⁻²."""
    axes.set_xscale("log")
    _plain_powers(axes.xaxis, *axes.get_xlim())


def log_axis_up(axes: Axes) -> None:
    """The same for the y axis; called when the curves are drawn."""
    axes.set_yscale("log")
    _plain_powers(axes.yaxis, *axes.get_ylim())


def _plain_powers(axis: Axis, low: float, high: float) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator

    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    # within a decade, more than its two ends; over several, the powers of ten are enough
    within = high < 10.0 * low
    axis.set_minor_locator(
        LogLocator(subs=(1.5, 2.0, 3.0, 5.0, 7.0) if within else (2.0, 3.0, 5.0))
    )
    named = high < 30.0 * low
    axis.set_minor_formatter(FuncFormatter(lambda value, _: f"{value:g}" if named else ""))
