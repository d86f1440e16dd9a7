"""`static-init` on load cells: the report."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footcal_cli.core.inference.observability import NextStep
from footcal_cli.core.next_stance import CurvePoint
from footcal_cli.core.online.weighed import Weighed
from footcal_cli.core.quiet import QuietSet
from footcal_cli.core.stances import StanceRows
from footcal_cli.core.static_init import StanceErrors, StaticInit
from footcal_cli.plots.stand import plot_curve, plot_stances
from footcal_cli.recipe import STANDARD_GRAVITY_MPS2
from footcal_cli.report import Picture
from footcal_cli.report.outcome import Outcome
from footcal_cli.sheets import stand as sheets

_NOTE = (
    "Gain in per cent and bias in newtons on top of the prior; parameters.json has scale and bias "
    "of the raw counts. Estimated: standing at least halved the sd. The others keep their prior "
    "and moved only as far as the sums over cells require."
)


def outcome_of(
    robot: str,
    rows: StanceRows,
    fit: StaticInit,
    errors: Sequence[StanceErrors],
    quiet: Sequence[QuietSet],
    curve: Sequence[CurvePoint],
    menu: Sequence[NextStep],
    weighed: Weighed,
) -> Outcome:
    """Scales and biases as far as standing shows them, and what to stand like next."""
    value = np.concatenate([fit.gain, fit.bias_n])
    sd = np.sqrt(np.diag(fit.covariance))
    status = fit.estimates.status
    seen = fit.observability
    shared_nm = float(np.abs(rows.shared).max(initial=0.0))
    com_sd_m = shared_nm / (weighed.stated_kg * STANDARD_GRAVITY_MPS2)
    verdict = sheets.verdict_of(fit, errors, menu, weighed, com_sd_m)
    drawn = (
        sheets.directions_picture(seen),
        sheets.beliefs_picture(
            rows, value, sd, status,
            "Change of each gain and bias by standing, in units of its prior sd; band: ± 2 sd.",
        ),
    )  # fmt: skip
    return Outcome(
        title=f"Standing calibration of {robot}",
        verdict=verdict,
        pictures=(*_error_pictures(errors, curve, verdict.sentence), *drawn),
        sheets=(
            sheets.beliefs_sheet(rows.names, rows.units, value, sd, rows.prior_sd, status, _NOTE),
            sheets.directions_sheet(seen),
            *((sheets.menu_sheet(menu),) if menu else ()),
            *((sheets.curve_sheet(curve),) if curve else ()),
            sheets.stances_sheet(errors, rows.effective_samples),
        ),
        footer=(
            "Model: Σ(1 + γ)F⁰ + β per cell against weight and projected CoM (NAO CoP "
            "self-calibration, eqs. 12, 13), maximum a posteriori in centred units; the prior "
            "is --parameters or the nameplate.",
            _worth(rows),
        ),
        rmse=sheets.rmse_of(errors, quiet),
        reference_sd=dict.fromkeys(("cop_x", "cop_y"), com_sd_m),
    )


def _error_pictures(
    errors: Sequence[StanceErrors], curve: Sequence[CurvePoint], sentence: str
) -> tuple[Picture, ...]:
    """Errors on the next stance and on each, as far as there are several."""
    pictures = []
    if curve:
        pictures.append(
            Picture(
                "curve", lambda: plot_curve(curve),
                "CoP error on the next, held-out stance after one, two, five … stances: with the "
                "prior it falls; without a prior, least squares needs many stances.",
                title="Error on the next stance against the number of stances",
                result=f"After {curve[-1].stances} stances {1e3 * curve[-1].after_m:.2g} mm, with "
                f"the prior alone {1e3 * curve[-1].before_m:.2g} mm.",
            )
        )  # fmt: skip
    if errors[0].vgrf_n.size > 1:
        pictures.append(
            Picture(
                "stances", lambda: plot_stances(errors),
                "Error of each stance before and after, and by least squares without a prior.",
                title="Error of each stance before and after",
                result=sentence,
            )
        )  # fmt: skip
    return tuple(pictures)


def _worth(rows: StanceRows) -> str:
    """What the means of stances were taken to be worth."""
    best = {
        name: float(rows.sd[[o == name for o in rows.output]].min())
        for name in ("fz", "mx", "my")
        if name in rows.output
    }
    moment = [best[name] for name in ("mx", "my") if name in best]
    said = f"A stance's mean counts {best['fz']:.2g} N in force" if "fz" in best else "Moments"
    said += f" and {1e3 * min(moment):.2g} N·mm in moment at best" if moment else " at best"
    shared = np.abs(rows.shared).max(initial=0.0)
    alike = (
        f" All stances share a CoM in a wrong place, up to {1e3 * shared:.2g} N·mm (1 sd)."
        if shared
        else ""
    )
    return f"{said}, whatever its length.{alike}"
