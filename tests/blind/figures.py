"""Figures of the bench: confusion, power, what could be reached, risk against coverage."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from footcal_cli.plots.style import AFTER, BAD, REFERENCE, new_figure, tidy
from tests.blind.scoring import Score, Share, risk_coverage

COLUMNS = (
    "right name", "right name + unknown", "rivals with it", "rivals without it", "wrong name",
    "wrong name + unknown", "unknown", "none", "underpowered", "bad-data", "error",
)  # fmt: skip


def draw_confusion(scores: Sequence[Score], path: Path) -> None:
    """Truth by verdict, in per cent of the row."""
    rows = sorted({s.row for s in scores}, key=lambda r: (r in ("none", "unseen", "left out"), r))
    table = np.array(
        [[sum(s.row == r and s.column == c for s in scores) for c in COLUMNS] for r in rows]
    )
    total = table.sum(axis=1, keepdims=True)
    figure = new_figure(1.6 + 0.26 * len(rows))
    axes = figure.add_subplot()
    axes.imshow(table / np.maximum(total, 1), cmap="Blues", vmin=0, vmax=1, aspect="auto")
    for i, j in np.argwhere(table > 0):
        share = table[i, j] / total[i, 0]
        bad = COLUMNS[j].startswith("wrong")
        colour = BAD if bad else "white" if share > 0.6 else REFERENCE
        axes.text(j, i, f"{100 * share:.0f}", ha="center", va="center", fontsize=7, color=colour)
    tidy(axes, "What was hidden (rows) and what was said (columns), % of the row")
    axes.grid(visible=False)
    axes.set_xticks(range(len(COLUMNS)), COLUMNS, rotation=35, ha="right")
    axes.set_yticks(
        range(len(rows)), [f"{r}  (n = {n})" for r, n in zip(rows, total[:, 0], strict=True)]
    )
    figure.savefig(path, dpi=110)


def draw_power(scores: Sequence[Score], path: Path) -> None:
    """Right and exact answers against ρ, one panel per experiment, with Wilson bands."""
    singles = [s for s in scores if s.truth["kind"] in ("single", "alias") and s.matters]
    groups = sorted({s.group for s in singles})
    if not groups:
        return
    figure = Figure(figsize=(11.0, 2.9))
    FigureCanvasAgg(figure)
    figure.subplots_adjust(left=0.06, right=0.99, top=0.84, bottom=0.3, wspace=0.15)
    panels = figure.subplots(1, len(groups), sharex=True, sharey=True, squeeze=False).ravel()
    for panel, group in zip(panels, groups, strict=True):
        mine = [s for s in singles if s.group == group]
        for flag, colour, name in (
            ("right", AFTER, "right: named, or among its rivals"),
            ("exact", REFERENCE, "exact: named alone (no designed alias)"),
        ):
            counted = [s for s in mine if flag == "right" or s.truth["kind"] == "single"]
            rhos = sorted({float(s.truth["rho"]) for s in counted})
            if not rhos:
                continue
            shares = [
                Share.of(getattr(s, flag) for s in counted if s.truth["rho"] == r) for r in rhos
            ]
            low, high = np.array([s.wilson() for s in shares]).T
            panel.plot(rhos, [s.value for s in shares], "o-", color=colour, ms=3, lw=1, label=name)
            panel.fill_between(rhos, low, high, color=colour, alpha=0.15, lw=0)
        tidy(panel, f"{group}\nn = {len(mine)}")
        panel.set_ylim(-0.03, 1.03)
        panel.set_xticks((0.3, 0.5, 1.0))
        panel.axhline(0.8, color="#cccccc", lw=0.7)
    panels[0].set_ylabel("share of trials")
    figure.supxlabel("ρ: what calibration cannot absorb, RMS over noise RMS", fontsize=9, y=0.12)
    handles, names = panels[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="lower center", ncols=2, fontsize=8, frameon=False)
    figure.savefig(path, dpi=110)


def draw_limits(scores: Sequence[Score], path: Path) -> bool:
    """Exact names: measured beside what an oracle reaches; False where no ledger says."""
    singles = [
        s for s in scores if s.truth["kind"] == "single" and s.matters and s.truth.get("limit")
    ]
    if not singles:
        return False
    groups = sorted({s.group for s in singles}, reverse=True)
    rhos = sorted({float(s.truth["rho"]) for s in singles})
    figure = Figure(figsize=(9.0, 1.3 + 0.3 * len(groups)))
    FigureCanvasAgg(figure)
    figure.subplots_adjust(left=0.13, right=0.98, top=0.88, bottom=0.24, wspace=0.12)
    panels = figure.subplots(1, len(rhos), sharey=True, squeeze=False).ravel()
    for panel, rho in zip(panels, rhos, strict=True):
        for at, group in enumerate(groups):
            mine = [s for s in singles if s.group == group and s.truth["rho"] == rho]
            if not mine:
                continue
            share = Share.of(s.exact for s in mine)
            most = 100 * float(np.mean([s.truth["limit"]["exact"] for s in mine]))
            panel.barh(at, most, height=0.6, color="#dde3ea", label="an oracle reaches")
            low, high = (100 * bound for bound in share.wilson())
            panel.plot([low, high], [at, at], color=AFTER, lw=1)
            panel.plot(100 * share.value, at, "o", color=AFTER, ms=5, label="measured")
        tidy(panel, f"effect {rho:g} × the noise")
        panel.set_xlim(0, 101)
        panel.set_xticks((0, 25, 50, 75, 100))
        panel.grid(visible=False, axis="y")
    panels[0].set_yticks(range(len(groups)), groups)
    figure.supxlabel("trials with the exact name, %", fontsize=9, y=0.09)
    found = dict(zip(*panels[0].get_legend_handles_labels()[::-1], strict=True))
    figure.legend(
        list(found.values()), list(found), loc="lower center", ncols=2, fontsize=8, frameon=False
    )
    figure.savefig(path, dpi=110)
    return True


def draw_risk(scores: Sequence[Score], path: Path) -> None:
    """Wrong names against names given, as the confidence that is asked for falls."""
    figure = new_figure(3.2, width_in=6.5)
    axes = figure.add_subplot()
    known = [s for s in scores if s.truth["kind"] in ("single", "alias", "pair")]
    for colour, name, kinds in (
        (AFTER, "a cause of the table was hidden", ("single", "alias", "pair")),
        (BAD, "a cause that is not in it", ("unseen", "left_out")),
        (REFERENCE, "nothing", ("null",)),
    ):
        mine = [s for s in scores if s.truth["kind"] in kinds]
        if not mine:
            continue
        coverage, risk = (100.0 * share for share in risk_coverage(known, mine))
        axes.plot([0.0, *coverage], [0.0, *risk], color=colour, drawstyle="steps-post",
                  label=f"{name}  (n = {len(mine)})")  # fmt: skip
    tidy(
        axes,
        "Taking less sure names: more names, more wrong ones",
        "logs with a cause of the table that get a certain name, %",
        "logs with a wrong name, %",
    )
    axes.set_ylim(-0.1, max(5.0, axes.get_ylim()[1]))
    axes.legend(fontsize=8, frameon=False, loc="upper left")
    figure.savefig(path, dpi=110)
