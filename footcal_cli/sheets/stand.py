"""Tables and verdict of `static-init`."""

from __future__ import annotations

from collections.abc import Sequence
from math import log

import numpy as np

from footcal_cli.core.inference.observability import NextStep, Observability
from footcal_cli.core.next_stance import CurvePoint
from footcal_cli.core.online.weighed import Weighed
from footcal_cli.core.parameters import FloatArray, Status
from footcal_cli.core.quiet import QuietSet
from footcal_cli.core.signals import root_mean_square
from footcal_cli.core.stances import StanceRows
from footcal_cli.core.static_init import StanceErrors, StaticInit
from footcal_cli.plots.stand import plot_beliefs, plot_directions
from footcal_cli.records.results import RmseRecord, RmseRow, VerdictRecord
from footcal_cli.report import Picture, Sheet, number, with_sd

MISFIT = 9.0
"""chi² per row beyond which more than noise and prior is left: no fit to be called good."""


def beliefs_sheet(
    names: Sequence[str],
    units: Sequence[str],
    value: FloatArray,
    sd: FloatArray,
    prior_sd: FloatArray,
    status: Sequence[Status],
    note: str,
) -> Sheet:
    """Every unknown on top of its prior: change, sd, sd before, and whether the log taught it."""
    rows: list[tuple[str, ...]] = []
    for name, unit, v, s, before in zip(names, units, value, sd, prior_sd, strict=True):
        factor, shown = (100.0, "%") if unit == "-" else (1.0, unit)
        rows.append(
            (name, with_sd(factor * float(v), factor * float(s)), shown,
             number(factor * float(before), 2), str(status[len(rows)]))
        )  # fmt: skip
    return Sheet(
        "Calibration",
        ("unknown", "change ± sd", "unit", "sd before", "status"),
        rows,
        note=note,
        greyed=frozenset(i for i, one in enumerate(status) if one is not Status.ESTIMATED),
    )


def stances_sheet(errors: Sequence[StanceErrors], effective: FloatArray) -> Sheet:
    """Errors of each stance by stage."""
    rows = []
    for e in errors:
        for k in range(e.vgrf_n.size):
            rows.append(
                (
                    str(k + 1),
                    e.stage,
                    "predicted from the others" if e.held_out else "fitted",
                    number(float(e.vgrf_n[k]), 3),
                    number(1e3 * float(e.cop_m[k, 0]), 3),
                    number(1e3 * float(e.cop_m[k, 1]), 3),
                    number(float(effective[k]), 3),
                )
            )
    return Sheet(
        "Stances",
        ("stance", "stage", "how", "force error (N)", "CoP x (mm)", "CoP y (mm)",
         "independent samples"),
        rows[:300],
        note="Against weight and projected CoM. Least squares is eq. (13) of NAO CoP "
             "self-calibration as printed, "
        "without a prior.",
    )  # fmt: skip


def curve_sheet(curve: Sequence[CurvePoint]) -> Sheet:
    """CoP error on the next stance by number of stances."""
    rows = [
        (
            str(point.stances),
            str(point.rank),
            *(number(1e3 * v, 3) for v in (point.before_m, point.after_m, point.least_squares_m)),
            str(point.tried),
        )
        for point in curve
    ]
    return Sheet(
        "How many stances",
        ("stances", "directions seen", "prior alone (mm)", "with the stances (mm)",
         "least squares (mm)", "runs"),
        rows,
        note="RMS distance of the CoP on the stance that follows, over all runs of so many "
        "successive stances. For two feet of four cells one stance sees 3 of 16 directions (total "
        "force, CoP x and y), ten with the feet left in place 11, with the feet put down anew 14; "
        "the last two, the feet's twists, show only when a foot is lifted.",
    )  # fmt: skip


def unseen_words(found: Observability, count: int) -> list[str]:
    """What is seen worst, in words."""
    if found.rank == 1:
        return ["every difference between single cells; only the sum of all is seen"]
    return found.weakest(count)


def directions_sheet(found: Observability) -> Sheet:
    """Rank, singular values, and what is not seen in words."""
    values = ", ".join(
        number(float(v), 3) if i < found.rank else "0" for i, v in enumerate(found.singular_values)
    )
    unseen = unseen_words(found, 6)
    label = "not seen" if found.rank < found.unknowns else "seen worst"
    rows = [
        ("rank", f"{found.rank} of {found.unknowns}"),
        ("singular values", values),
        *((f"{label} {i + 1}", words) for i, words in enumerate(unseen)),
    ]
    return Sheet("What these stances determine", ("quantity", "value"), rows)


def directions_picture(found: Observability) -> Picture:
    """How well the stances determine each direction."""
    return Picture(
        "directions", lambda: plot_directions(found.singular_values, found.rank),
        "How well the stances determine each direction; those without a bar keep the prior.",
        title="How well each parameter direction is observed",
        result=f"{found.rank} of {found.unknowns} parameter directions are observed.",
    )  # fmt: skip


def beliefs_picture(
    rows: StanceRows, value: FloatArray, sd: FloatArray, status: Sequence[Status], caption: str
) -> Picture:
    """Every unknown before and after standing."""
    known = [one is Status.ESTIMATED for one in status]
    return Picture(
        "beliefs",
        lambda: plot_beliefs(rows.names, rows.units, rows.prior_sd, value, sd, known),
        caption,
        title="Each parameter before and after standing",
        result=f"{sum(known) or 'None'} of {len(known)} {'is' if sum(known) == 1 else 'are'} "
        "estimated.",
    )


def menu_sheet(menu: Sequence[NextStep]) -> Sheet:
    """Which stance to add next."""
    rows = [
        (
            step.name,
            number(step.gain_nats / log(2.0), 3),
            f"{100 * (1 - step.sd_ratio):.0f} %",
            str(step.rank),
            step.direction,
        )
        for step in menu
    ]
    return Sheet(
        "Stances to record next",
        ("stance", "information gain (bits)", "best direction's sd falls by", "rank then",
         "that direction"),
        rows,
        note="Expected from the geometry of the last stance; a squat only repeats what is known "
        "(it distinguishes a CoM offset from a tilted IMU, not one cell from another).",
    )  # fmt: skip


def counted(stances: int) -> str:
    """``1 stance shows``, ``5 stances show``."""
    return "1 stance shows" if stances == 1 else f"{stances} stances show"


def _how_many(known: int, unknowns: int) -> str:
    if known == unknowns:
        return f"All {unknowns} parameters are estimated."
    if known == 0:
        return (
            f"Standing determines sums over cells, but none of the {unknowns} parameters by itself:"
            " each keeps its prior, moved as far as the sums demand."
        )
    return f"{known} of {unknowns} parameters are estimated; the others keep their prior."


def verdict_of(
    fit: StaticInit,
    errors: Sequence[StanceErrors],
    menu: Sequence[NextStep],
    weighed: Weighed,
    com_sd_m: float,
) -> VerdictRecord:
    """The first sentence and what it rests on; `com_sd_m`: of the CoM's place."""
    stances = errors[0].vgrf_n.size
    known = sum(status == "estimated" for status in fit.estimates.status)
    seen = fit.observability
    held = any(e.held_out for e in errors)
    by_stage = {e.stage: e for e in errors if e.held_out == held}
    cop_mm = {k: 1e3 * root_mean_square(e.cop_m) * 2**0.5 for k, e in by_stage.items()}
    force_n = {k: root_mean_square(e.vgrf_n) for k, e in by_stage.items()}
    has_cop = cop_mm["before"] == cop_mm["before"]
    shown = (
        f"CoP error {number(cop_mm['before'], 2)} → {number(cop_mm['after'], 2)} mm"
        if has_cop
        else f"total force error {number(force_n['before'], 2)} → {number(force_n['after'], 2)} N"
    )
    actions: list[str] = []
    details = [
        _how_many(known, seen.unknowns),
        f"Not seen: {'; '.join(unseen_words(seen, 3))}."
        if seen.rank < seen.unknowns
        else f"Seen worst: {'; '.join(seen.weakest(2))}.",
    ]
    if has_cop and held:
        details.append(_against_what(cop_mm["least squares"], com_sd_m))
    if menu:
        best = menu[0]
        actions.append(
            f"Next stance to record: {best.name} (+{number(best.gain_nats / log(2.0), 2)} bits of "
            f"information, rank {best.rank})."
        )
    details.append(_how_well_weighed(weighed))
    how = "on held-out stances" if held else "on the fitted stance"
    return VerdictRecord(
        level="good" if known == seen.unknowns and fit.chi2 <= MISFIT * fit.dof else "warning",
        sentence=f"{counted(stances)} {seen.rank} of {seen.unknowns} parameter directions; {shown} "
        f"{how}.",
        actions=tuple(actions),
        details=tuple(details),
    )


def _how_well_weighed(weighed: Weighed) -> str:
    """Which error of the stated mass cells could not show, and what the recipe says of it."""
    hidden, stated = number(weighed.hidden_kg, 2), weighed.stated_sd_kg
    if stated is not None and stated < weighed.hidden_kg:
        return (
            f"The mass is taken as known to {number(stated, 2)} kg, as mass_sd_kg says: the cells "
            f"would show an error of more than {hidden} kg only."
        )
    return (
        f"An error of the stated mass below {hidden} kg would not show here, "
        "because zeros and scales are not known better: weigh the robot."
    )


def _against_what(least_squares_mm: float, com_sd_m: float) -> str:
    """How well the reference of the CoP error is known, and what a fit without a prior does."""
    said = f"Least squares without a prior comes within {number(least_squares_mm, 2)} mm of it"
    if not com_sd_m:
        return f"The CoP is judged by the model's CoM. {said}."
    unsure = number(1e3 * com_sd_m, 2)
    return (
        f"The CoP is judged by the model's CoM, which may itself lie {unsure} mm off (1 sd): a "
        f"smaller error proves nothing. {said} by copying that error into the biases."
    )


def rmse_of(errors: Sequence[StanceErrors], quiet: Sequence[QuietSet]) -> RmseRecord:
    """Errors of the stances as ``rmse.json`` has them."""
    rows: list[RmseRow] = []
    for e in errors:
        series = {"vgrf": e.vgrf_n, "cop_x": e.cop_m[:, 0], "cop_y": e.cop_m[:, 1]}
        for quantity, values in series.items():
            if np.isfinite(values).any():
                rows.append(
                    RmseRow.of(
                        quantity, "N" if quantity == "vgrf" else "m", e.stage.replace(" ", "_"),
                        "weight and projected CoM", values, "held_out" if e.held_out else "all",
                    )
                )  # fmt: skip
    return RmseRecord(rows=tuple(rows), rejected=_rejected(quiet))


def offset_rmse_of(rows: StanceRows, values: FloatArray, quiet: Sequence[QuietSet]) -> RmseRecord:
    """Errors of six-axis feet per row as ``rmse.json`` has them."""
    after = rows.error + rows.h @ (values / rows.prior_sd)
    output = np.array(rows.output)
    found = tuple(
        RmseRow.of(name, unit_of(name), stage, "weight and CoM", left[output == name])
        for name in dict.fromkeys(rows.output)
        for stage, left in (("before", rows.error), ("after", after))
    )
    return RmseRecord(rows=found, rejected=_rejected(quiet))


def unit_of(output: str) -> str:
    """Unit of an output of the balance by its name: ``fz``, ``mx``, ``left.ty``."""
    return "Nm" if output.split(".")[-1][0] in "mt" else "N"


def _rejected(quiet: Sequence[QuietSet]) -> dict[str, int]:
    rejected: dict[str, int] = {}
    for one in quiet:
        for reason, count in one.validity.counts.items():
            rejected[reason] = rejected.get(reason, 0) + count
    return rejected
