"""Curves of a figure as numbers, so that a report can zoom into them and read values off.

They are taken from the drawn figure itself: what is seen large is what is seen small.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from footcal_cli.core.signals import peaks_kept

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

MOST_POINTS = 1500
"""Points of one curve in a page; of more, each stretch keeps its smallest and its largest."""
_FEWEST_POINTS = 3
_DIGITS = 6


def curves_of(figure: Figure) -> str:
    """The curves of every panel as JSON for ``report.js``; empty where there are none.

    Returns
    -------
    str
        ``[{"title", "x", "y", "curves": [{"label", "colour", "points", "x", "y"}]}]``.
    """
    panels = [panel for axes in figure.axes if axes.get_visible() and (panel := _panel(axes))]
    if not panels:
        return ""
    # within a page, a log's own words must not end the element that holds them
    return json.dumps(panels, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")


def _panel(axes: Axes) -> dict[str, Any]:
    lines = [line for line in axes.get_lines() if _is_data(line, axes)]
    if not lines:
        return {}
    shared = list(axes.get_shared_x_axes().get_siblings(axes))
    x_labels = [axes.get_xlabel(), *(other.get_xlabel() for other in shared)]
    title = axes.get_title(loc="left") or axes.get_title(loc="right") or axes.get_title()
    return {
        "title": title,
        "x": next((label for label in x_labels if label), ""),
        "y": axes.get_ylabel(),
        "curves": [_curve(line, title or axes.get_ylabel() or "value") for line in lines],
    }


def _is_data(line: Line2D, axes: Axes) -> bool:
    """Not a rule across the panel, nor a mark on its edge."""
    return line.get_transform() == axes.transData and np.size(line.get_xdata()) >= _FEWEST_POINTS


def _curve(line: Line2D, otherwise: str) -> dict[str, Any]:
    """A curve; `otherwise` is its label where it has none of its own."""
    from matplotlib.colors import to_hex

    label = str(line.get_label())
    x, y = _thinned(*np.asarray(line.get_xydata(), dtype=float).T)
    return {
        "label": otherwise if label.startswith("_") else label,
        "colour": to_hex(line.get_color()),
        "points": str(line.get_linestyle()) in {"None", "none", "", " "},
        "x": _rounded(x),
        "y": _rounded(y),
    }


def _thinned(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """By increasing x; of every stretch the extremes, and where the curve is cut."""
    order = np.argsort(x, kind="stable")
    x, y = x[order], y[order]
    known = np.isfinite(x)
    x, y = x[known], y[known]
    if x.size <= MOST_POINTS:
        return x, y
    kept = peaks_kept(y, 2 * MOST_POINTS // 3)
    missing = ~np.isfinite(y)
    cuts = np.flatnonzero(missing & ~np.concatenate([[False], missing[:-1]]))
    kept = np.union1d(kept, cuts[: MOST_POINTS // 3])
    return x[kept], y[kept]


def _rounded(values: np.ndarray) -> list[float | None]:
    """Numbers with a few digits of their spread; None where there is none, as JSON knows no NaN."""
    finite = values[np.isfinite(values)]
    spread = float(np.ptp(finite)) if finite.size else 0.0
    decimals = _DIGITS - 1 - int(np.floor(np.log10(spread))) if spread > 0 else _DIGITS
    return [round(float(v), decimals) if np.isfinite(v) else None for v in values]
