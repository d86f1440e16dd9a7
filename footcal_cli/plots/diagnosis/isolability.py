"""Which effects look alike in these data, and would after the proposed experiment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.diagnosis.answer import EffectStatus
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.menu import Menu
from footcal_cli.core.diagnosis.next_experiment import rig_at
from footcal_cli.core.diagnosis.plans import Plan
from footcal_cli.core.diagnosis.rehearsal import rehearsed
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.parameters import FloatArray
from footcal_cli.plots.style import BAD, new_figure
from footcal_cli.plots.words import words

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CAPTION = (
    "Likeness of effects after the calibration is fitted, |cos|: 0 (blank) none, 1 (full shade) "
    "the same. "
    "Framed: groups so alike (|cos| > 0.95) that only a large effect is distinguished in them."
)
AFTER_CAPTION = (
    "Likeness of effects after the calibration is fitted, |cos|: 0 (blank) none, 1 (full shade) "
    "the same. "
    "Left panel: these data; right panel: the proposed experiment. Framed: groups so alike "
    "(|cos| > 0.95) that only a large effect is distinguished in them. Hatched: not visible."
)
_SAME = 0.95
_SHOWN = 0.02  # visible share from which an effect is worth comparing
_CELL_IN = 0.17


def plot_isolability(
    found: Investigation, table: Mapping[str, Effect], menu: Menu | None
) -> Figure:
    """|cos| of the visible signatures, one row per effect where it explains most; now and then."""
    signatures = _compared(found)
    if not signatures:
        figure = new_figure(0.9)
        figure.text(0.5, 0.5, "No effect is visible in these data.", ha="center")
        return figure
    now = _now(found, signatures)
    order = _clustered(now)
    ordered = [signatures[i] for i in order]
    names = [s.effect for s in ordered]
    panels = [("Likeness |cos| in these data", now[np.ix_(order, order)])]
    if menu is not None and menu.best is not None:
        then = _then(found, table, menu.best.plan, ordered)
        panels.append((f"After '{menu.best.plan.id.replace('_', ' ')}'", then))
    side = _CELL_IN * len(names)
    margin, below = 1.35, 1.15
    width = margin + len(panels) * (side + 0.25) + 0.6
    height = side + below + 0.35
    figure = new_figure(height, width_in=width)
    figure.set_layout_engine("none")
    for i, (title, cos) in enumerate(panels):
        left = margin + i * (side + 0.25)
        axes = figure.add_axes((left / width, below / height, side / width, side / height))
        _draw(axes, cos, names, title, named=i == 0)
    bar = figure.add_axes(
        ((margin + len(panels) * (side + 0.25)) / width, below / height, 0.09 / width,
         min(side, 1.8) / height)
    )  # fmt: skip
    figure.colorbar(figure.axes[0].images[0], cax=bar).ax.tick_params(labelsize=6.5)
    return figure


def alike(found: Investigation) -> str:
    """Which effects these data hardly distinguish, in one sentence."""
    signatures = _compared(found)
    if not signatures:
        return "No effect is visible in these data."
    cos = _now(found, signatures)
    order = _clustered(cos)
    names = [words(signatures[i].effect) for i in order]
    groups = [
        ", ".join(names[first : last + 1]) for first, last in _runs(cos[np.ix_(order, order)])
    ]
    if not groups:
        return f"No two of {len(names)} effects look alike (|cos| > {_SAME})."
    return f"Alike (|cos| > {_SAME}) of {len(names)} effects: {'; '.join(groups)}."


def _compared(found: Investigation) -> tuple[Signature, ...]:
    """A signature of each effect that the data show: where it explains most, rivals as copies."""
    copies = {s.effect: s for f in found.found for s in (*f.cause.rivals, f.cause.signature)}
    known = set(found.problem.signatures)
    chosen = []
    for row in found.rounds[0].effects:
        if row.status is EffectStatus.NOT_TESTABLE and row.visible < _SHOWN:
            continue
        signature = copies.get(row.signature.effect, row.signature)
        chosen.append(signature if signature in known else row.signature)
    return tuple(s for s in chosen if s in known)


def _then(
    found: Investigation, table: Mapping[str, Effect], plan: Plan, signatures: Sequence[Signature]
) -> FloatArray:
    """|cos| between effects in a planned experiment, shape (k, k); a row of zeros hides there."""
    where = rehearsed(plan, rig_at(found))
    columns = []
    for signature in signatures:
        effect = table[signature.effect]
        size = next(p for p in effect.sizes if p.name == signature.parameter)
        value = float(np.clip(size.neutral + size.prior_sd, size.lower, size.upper))
        values = {**dict(signature.shape), size.name: value}
        columns.append(where.shown(effect, signature, values))
    shown = np.stack(columns, axis=1)
    norm = np.sqrt(np.sum(shown**2, axis=0))
    unit = np.divide(shown, norm, out=np.zeros_like(shown), where=norm > 0)
    return np.asarray(np.abs(unit.T @ unit))


def _now(found: Investigation, signatures: Sequence[Signature]) -> FloatArray:
    """|cos| between effects in the data at hand, shape (k, k)."""
    problem = found.problem
    index = {s: i for i, s in enumerate(problem.signatures)}
    chosen = [index[s] for s in signatures]
    part = replace(problem, columns=problem.columns[:, chosen], signatures=tuple(signatures))
    left = part.left()
    norm = np.sqrt(np.sum(left**2, axis=0))
    unit = left / np.where(norm > 0, norm, 1.0)
    return np.asarray(np.abs(unit.T @ unit))


def _draw(axes: Axes, cos: FloatArray, names: Sequence[str], title: str, *, named: bool) -> None:
    from matplotlib.patches import Rectangle

    k = len(names)
    axes.imshow(cos, cmap="Blues", vmin=0, vmax=1)
    for i in np.flatnonzero(np.diag(cos) == 0):
        for x, y, width, height in ((-0.5, i - 0.5, k, 1), (i - 0.5, -0.5, 1, k)):
            axes.add_patch(
                Rectangle((x, y), width, height, fill=False, hatch="/////", linewidth=0,
                          edgecolor="#d5d9df")
            )  # fmt: skip
    for first, last in _runs(cos):
        side = last - first + 1
        axes.add_patch(
            Rectangle(
                (first - 0.5, first - 0.5), side, side, fill=False, edgecolor=BAD, linewidth=1.8
            )
        )
    spelt = [words(name) for name in names]
    axes.set_xticks(range(k), spelt, rotation=90, fontsize=6.5)
    axes.set_yticks(range(k), spelt if named else [], fontsize=6.5)
    axes.tick_params(length=0)
    axes.set_title(title, loc="left", fontsize=9)
    for side_name in ("top", "right", "left", "bottom"):
        axes.spines[side_name].set_color("#c9ced6")


def _runs(cos: FloatArray) -> list[tuple[int, int]]:
    """Neighbouring effects each of which looks like the next: first and last of every group."""
    runs = []
    start = 0
    for i in range(1, len(cos) + 1):
        if i == len(cos) or cos[i - 1, i] <= _SAME:
            if i - start > 1:
                runs.append((start, i - 1))
            start = i
    return runs


def _clustered(cos: FloatArray) -> list[int]:
    """An order that keeps look-alikes together: nearest neighbour after nearest neighbour."""
    rest = list(range(len(cos)))
    order = [rest.pop(0)]
    while rest:
        nearest = max(rest, key=lambda j: cos[order[-1], j])
        rest.remove(nearest)
        order.append(nearest)
    return order
