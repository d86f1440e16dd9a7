"""Figures of `online-replay`: [NAO]'s Figs. 10–15, and the evidence it asks for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from footcal_cli.core.online.comparison import ReplayedWalk
from footcal_cli.core.online.evidence import SETTLING_S
from footcal_cli.core.online.filter import Track
from footcal_cli.core.online.jumps import BiasJump
from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.core.signals import peaks_kept
from footcal_cli.core.study.sensitivity import Sensitivity
from footcal_cli.plots.forces import FootOutline, plot_cop_in_feet
from footcal_cli.plots.style import (
    AFTER,
    BAD,
    BEFORE,
    CELL_COLOURS,
    MOST_POINTS,
    REFERENCE,
    legend_below,
    new_figure,
    tidy,
)
from footcal_cli.plots.words import capital, output_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

METHOD_COLOURS = {
    "before": BEFORE,
    "static": CELL_COLOURS[5],
    "window": BAD,
    "memory": AFTER,
    "smoother": CELL_COLOURS[2],
    "baseline": CELL_COLOURS[7],
}
METHOD_LABELS = {
    "before": "before (parameters as given)",
    "static": "static (zero acceleration)",
    "window": "window (sliding)",
    "memory": "memory (filter)",
    "smoother": "smoother (whole walk)",
    "baseline": "offline calibration",
}
"""Method as the tables name it, and what it is, for legends."""
_SHOWN_S = 6.0
_MOST_CURVES = 6
_MOST_DOTS = 20_000


def _excerpt(found: ReplayedWalk, span_s: tuple[float, float] | None) -> BoolArray:
    """Samples within a span from the first one; else the last seconds, where all have settled."""
    time_s = found.merged.log.time_s
    low, high = (time_s[-1] - _SHOWN_S - 1.0, time_s[-1] - 1.0)
    if span_s is not None:
        low, high = (time_s[0] + edge for edge in span_s)
    rows = np.asarray((time_s >= low) & (time_s <= high))
    return rows if rows.any() else np.ones(time_s.size, dtype=bool)


def _drawn_reference(found: ReplayedWalk) -> tuple[str, FloatArray, FloatArray]:
    """What the methods are judged against, drawn in black: its name, CoP (n, 2) and force (n,)."""
    if found.best_reference == "motion":
        return "demanded by the motion", found.reference.cop_m, found.reference.fz_n
    kind = {"truth": "true", "baseline": "baseline"}[found.best_reference]
    name = {"truth": "truth", "baseline": "offline calibration"}[found.best_reference]
    one = found.replayed[kind].total
    return name, one.cop_m, one.fz_n


def plot_cop(
    found: ReplayedWalk, methods: Sequence[str], span_s: tuple[float, float] | None = None
) -> Figure:
    """CoP x and y, as [NAO]'s Figs. 10, 12, 14, and the errors beside.

    Parameters
    ----------
    methods
        Drawn in colour over what they are judged against.
    span_s
        From and to, s from the first sample; None: the last seconds.
    """
    figure = new_figure(4.2)
    rows = _excerpt(found, span_s)
    time_s = found.merged.log.time_s[rows]
    label, reference, _ = _drawn_reference(found)
    panels = figure.subplots(2, 2, sharex=True)
    for (left, right), axis, name in zip(panels, (0, 1), "xy", strict=True):
        com = found.merged.log.known["com_m"][rows, axis]
        shown = 1e3 * (reference[rows, axis] - com)
        left.plot(time_s, shown, color=REFERENCE, linewidth=2.2, label=label)
        for method in methods:
            cop = 1e3 * (found.replayed[method].total.cop_m[rows, axis] - com)
            colour = METHOD_COLOURS[method]
            left.plot(time_s, cop, color=colour, linewidth=1.0, label=METHOD_LABELS[method])
            if method != methods[0]:
                right.plot(time_s, cop - shown, color=colour, linewidth=1.0)
        right.axhline(0.0, color=REFERENCE, linewidth=0.6)
        below = "time (s)" if name == "y" else ""
        tidy(left, f"CoP {name} relative to the CoM", below, f"CoP {name} (mm)")
        tidy(right, f"CoP {name}, error of {' and '.join(methods[1:])}", below, "error (mm)")
    legend_below(figure)
    return figure


def plot_vgrf(
    found: ReplayedWalk, methods: Sequence[str], span_s: tuple[float, float] | None = None
) -> Figure:
    """Total vertical force, as [NAO]'s Figs. 11, 13, 15; parameters as `plot_cop`."""
    figure = new_figure(3.0)
    axes = figure.subplots()
    rows = _excerpt(found, span_s)
    time_s = found.merged.log.time_s[rows]
    label, _, reference = _drawn_reference(found)
    axes.plot(time_s, reference[rows], color=REFERENCE, linewidth=2.2, label=label)
    for method in methods:
        force = found.replayed[method].total.fz_n[rows]
        axes.plot(
            time_s, force, color=METHOD_COLOURS[method], linewidth=1.0, label=METHOD_LABELS[method]
        )
    tidy(axes, "Vertical ground reaction force", "time (s)", "force (N)")
    legend_below(figure)
    return figure


def plot_path(found: ReplayedWalk, feet: Mapping[str, FootOutline]) -> Figure:
    """CoP under both feet in the foot frames, with the support outline and the cells."""
    cop_m = {
        name: cop_in_foot(found, "memory", k, name, foot.cells_m)
        for k, (name, foot) in enumerate(feet.items())
    }
    return plot_cop_in_feet(cop_m, feet)


def cop_in_foot(
    found: ReplayedWalk, method: str, k: int, foot: str, cells_m: FloatArray
) -> FloatArray:
    """CoP (n, 2) under the k-th foot in its own frame, m."""
    log = found.merged.log
    first = next(i for i, c in enumerate(log.channels) if c.startswith(f"{foot}_"))
    yaw = log.known["foot_yaw_rad"][:, k]
    to_first = _turned(np.broadcast_to(cells_m[0], (len(yaw), 2)), -yaw)
    origin = log.known["cell_pos_m"][:, first] - to_first
    return _turned(found.replayed[method].feet[k].cop_m - origin, yaw)


def _turned(vector: FloatArray, yaw: FloatArray) -> FloatArray:
    """World vectors (n, 2) in a foot's frame."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.stack(
        [cos * vector[:, 0] + sin * vector[:, 1], -sin * vector[:, 0] + cos * vector[:, 1]], axis=1
    )


def plot_parameters(track: Track, jumps: Sequence[BiasJump], kinds: Sequence[str]) -> Figure:
    """Unknowns over time with ± 2 sd, a panel per kind; jumps as vertical lines."""
    chosen = {
        kind: [i for i, n in enumerate(track.names) if n.rsplit(".", 1)[-1].startswith(kind)]
        for kind in kinds
    }
    chosen = {kind: at for kind, at in chosen.items() if at}
    figure = new_figure(2.5 * len(chosen))
    panels = figure.subplots(len(chosen), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (kind, at) in zip(panels, chosen.items(), strict=True):
        percent = 100.0 if track.units[at[0]] == "-" else 1.0
        unit = "%" if track.units[at[0]] == "-" else track.units[at[0]]
        for colour, i in zip((*CELL_COLOURS, *CELL_COLOURS), at, strict=False):
            drawn = peaks_kept(track.values[:, i], MOST_POINTS)
            time_s, value = track.time_s[drawn], percent * track.values[drawn, i]
            sd = percent * track.sd[drawn, i]
            axes.plot(time_s, value, color=colour, linewidth=1.1, label=_owner(track.names[i]))
            axes.fill_between(
                time_s, value - 2 * sd, value + 2 * sd, color=colour, alpha=0.12, linewidth=0
            )
        for jump in jumps:
            if kind == "bias":
                axes.axvline(jump.onset_s, color=BAD, linewidth=1.0, linestyle="--")
        _to_settled(axes, track, [percent * track.values[:, i] for i in at],
                    [percent * track.sd[:, i] for i in at])  # fmt: skip
        tidy(axes, f"{kind.capitalize()} on top of the prior, ± 2 sd", "", f"{kind} ({unit})")
    panels[-1].set_xlabel("time (s)", fontsize=9)
    legend_below(figure, columns=8)
    return figure


def _to_settled(
    axes: Axes, track: Track, values: Sequence[FloatArray], sds: Sequence[FloatArray]
) -> None:
    """Limits that show what remains once the start has settled."""
    late = track.time_s - track.time_s[0] > min(SETTLING_S, 0.5 * np.ptp(track.time_s))
    low = min(float((v - 2 * sd)[late].min()) for v, sd in zip(values, sds, strict=True))
    high = max(float((v + 2 * sd)[late].max()) for v, sd in zip(values, sds, strict=True))
    if not np.isfinite([low, high]).all():  # numbers beyond all sense say so in the tables
        return
    room = 0.1 * max(high - low, 1e-9)
    axes.set_ylim(low - room, high + 2.5 * room)


def _owner(name: str) -> str:
    owner, _, kind = name.rpartition(".")
    return owner if kind in ("gain", "bias") else name


def plot_states(
    track: Track,
    names: Sequence[str],
    scale: Mapping[str, tuple[float, str]],
    on_top_of: Mapping[str, float],
) -> Figure:
    """What was wrong with the reference, over time with ± 2 sd; each on top of a first estimate."""
    figure = new_figure(1.5 * len(names) + 0.4)
    panels = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    for axes, name in zip(panels, names, strict=True):
        i = track.names.index(name)
        factor, unit = scale.get(name, (1.0, track.units[i]))
        value = factor * (track.values[:, i] + on_top_of.get(name, 0.0))
        sd = factor * track.sd[:, i]
        drawn = peaks_kept(value, MOST_POINTS)
        time_s, low, high = (x[drawn] for x in (track.time_s, value - 2 * sd, value + 2 * sd))
        axes.plot(time_s, value[drawn], color=AFTER, linewidth=1.1)
        axes.fill_between(time_s, low, high, color=AFTER, alpha=0.15)
        axes.axhline(0.0, color=REFERENCE, linewidth=0.6)
        _to_settled(axes, track, [value], [sd])
        tidy(axes, f"{capital(state_in_words(name))}, ± 2 sd", "", unit)
    panels[-1].set_xlabel("time (s)", fontsize=9)
    return figure


_STATES_IN_WORDS = {
    "robot.delay": "body stream later than compensated",
    "robot.com_correction_x": "CoM further forward than the model has it",
    "robot.com_correction_y": "CoM further left than the model has it",
    "robot.com_correction_z": "CoM higher than the model has it",
    "robot.angmom_loss": "share of the rate of angular momentum that the stream lacks",
    "robot.angmom_share_x": "angular momentum as a share of the body's motion ahead",
    "robot.angmom_share_y": "angular momentum as a share of the body's motion sideways",
    "robot.smoothing": "second moment of the filter that smoothed the acceleration",
    "robot.smoothing_fourth": "fourth moment of that filter, less what the second implies",
}


def state_in_words(name: str) -> str:
    """A state of the filter as an experimenter would say it."""
    if name.endswith(".plate_weight"):
        return f"plate hanging from the cells of the {name.split('.')[0]} foot"
    if name.endswith(".plate_mass"):
        return f"mass accelerated below the cells of the {name.split('.')[0]} foot"
    return _STATES_IN_WORDS.get(name, name)


def within_band(track: Track, outputs: int) -> str:
    """How many normalised innovations of the first outputs lie within ± 2 sd."""
    with np.errstate(invalid="ignore"):
        normalised = (track.innovation / track.innovation_sd)[:, :outputs]
    normalised = normalised[np.isfinite(normalised)]
    if not normalised.size:
        return "no update had a prediction."
    share = float(np.mean(np.abs(normalised) < 2.0))
    return f"{100 * share:.0f} % lie within ± 2 sd (95 % expected)."


def plot_innovations(track: Track, outputs: Sequence[str]) -> Figure:
    """Normalised innovations of the totals: they should fill ± 2 and show no pattern."""
    figure = new_figure(1.3 * len(outputs) + 0.5)
    panels = figure.subplots(len(outputs), 1, sharex=True, squeeze=False)[:, 0]
    with np.errstate(invalid="ignore"):
        normalised = track.innovation / track.innovation_sd
    for k, (axes, name) in enumerate(zip(panels, outputs, strict=True)):
        axes.axhspan(-2.0, 2.0, color="#eef1f4")
        drawn = peaks_kept(normalised[:, k], _MOST_DOTS)
        axes.plot(track.time_s[drawn], normalised[drawn, k], ".", markersize=1.5, color=AFTER)
        axes.set_ylim(-5.5, 5.5)
        title = capital(output_words(name))
        tidy(axes, f"{title}: innovation over its predicted sd (band: ± 2)", "", "sd")
    panels[-1].set_xlabel("time (s)", fontsize=9)
    return figure


def plot_sensitivity(curves: Sequence[tuple[str, Sensitivity]]) -> Figure:
    """CoP and force error as one setting is scaled by 0.2 … 5; the settings that matter most."""
    methods = [m for m in ("window", "memory") if any(m == method for method, _ in curves)]
    figure = new_figure(5.0)
    grid = figure.subplots(2, len(methods), sharey="row", sharex=True, squeeze=False)
    for column, method in zip(grid.T, methods, strict=True):
        chosen = [c for m, c in curves if m == method]
        chosen.sort(key=lambda curve: float(-np.ptp(curve.cop_m)))
        for colour, curve in zip(CELL_COLOURS, chosen[:_MOST_CURVES], strict=False):
            for axes, values in zip(column, (1e3 * curve.cop_m, curve.vgrf_n), strict=True):
                axes.plot(
                    curve.factors, values, "o-", color=colour, markersize=3, linewidth=1.0,
                    label=curve.setting,
                )  # fmt: skip
        for axes in column:
            axes.set_xscale("log")
            axes.set_xticks([0.2, 0.5, 1.0, 2.0, 5.0], ["0.2", "0.5", "1", "2", "5"])
            axes.minorticks_off()
            axes.set_ylim(bottom=0.0)
        title = f"{method.capitalize()}: each setting scaled"
        if len(chosen) > _MOST_CURVES:
            rest = 1e3 * float(np.ptp(chosen[_MOST_CURVES].cop_m))
            title += f" ({len(chosen) - _MOST_CURVES} others: < {rest:.2g} mm)"
        first = method == methods[0]
        tidy(column[0], title, "", "CoP RMSE (mm)" if first else "")
        tidy(column[1], "", "factor", "vertical force RMSE (N)" if first else "")
        column[1].legend(
            fontsize=6.5, frameon=False, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.22)
        )
    return figure


def plot_cycles(found: ReplayedWalk, methods: Sequence[str]) -> Figure:
    """Error of each gait cycle as violins, one per method."""
    reference, drawn = found.best_reference, []
    for quantity, title, factor, unit in (
        ("cop", "CoP", 1e3, "mm"), ("foot_cop", "CoP of each foot", 1e3, "mm"),
        ("vgrf", "vertical force", 1.0, "N"),
    ):  # fmt: skip
        each = {m: factor * found.of(m, reference).cycles(quantity) for m in methods}
        series = {m: v[np.isfinite(v)] for m, v in each.items()}
        series = {m: v for m, v in series.items() if v.size > 2}
        if series:  # a demand of the motion says nothing of each foot
            drawn.append((f"{capital(title)}, per gait cycle", f"RMSE ({unit})", series))
    figure = new_figure(3.0)
    panels = figure.subplots(1, max(len(drawn), 1), squeeze=False)[0]
    for axes, (title, label, series) in zip(panels, drawn, strict=False):
        _violins(axes, series)
        tidy(axes, title, "", label)
    return figure


def _violins(axes: Axes, series: Mapping[str, FloatArray]) -> None:
    from matplotlib.ticker import FormatStrFormatter, LogLocator

    place = np.arange(len(series)) + 1
    drawn = axes.violinplot(list(series.values()), positions=place, showmedians=True, widths=0.8)
    bodies: Any = drawn["bodies"]
    for body, method in zip(bodies, series, strict=True):
        body.set_facecolor(METHOD_COLOURS[method])
        body.set_alpha(0.6)
    for part in ("cbars", "cmins", "cmaxes", "cmedians"):
        drawn[part].set_color(REFERENCE)
        drawn[part].set_linewidth(0.8)
    axes.set_xticks(place, list(series), rotation=30)
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(FormatStrFormatter("%g"))
    axes.yaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
    axes.yaxis.set_minor_formatter(FormatStrFormatter("%g"))
    axes.tick_params(axis="y", which="minor", labelsize=7)
