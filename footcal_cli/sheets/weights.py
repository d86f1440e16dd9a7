"""Affine calibrations of load cells as tables, error rows and sentences."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from footcal_cli.core.bench.record import load_levels
from footcal_cli.core.bench.regression import AffineFit, Curvature, fit_affine
from footcal_cli.core.bench.study import ChannelStudy
from footcal_cli.core.parameters import FloatArray
from footcal_cli.core.quality import Finding
from footcal_cli.records.display_units import display_unit
from footcal_cli.records.results import RmseRow, Split
from footcal_cli.report import Sheet, number, plural, with_same_decimals, with_sd

NEXT_RECORDING = (
    "Run next: a ladder of at least six loads up to the intended load and down again, one hold "
    "of five minutes at the top and one unloaded, the whole repeated three times, each cell alone."
)
LACK_OF_FIT_ALPHA = 0.01
_CHANCE = 0.05  # p of the sign test below which channels are said to bend together
_COARSE = 0.1
"""A step of the converter above this share of the RMSE is worth a column."""
_MOST_ROWS = 200
_MOST_MISFITS = 3
_MOST_READINGS = 60


def inadequate(fits: Sequence[AffineFit], tolerance_n: float) -> list[AffineFit]:
    """Channels that a scale and a bias do not describe, worst first."""
    bad = [
        fit
        for fit in fits
        if fit.worst_n > tolerance_n
        or (fit.lack_of_fit is not None and fit.lack_of_fit.p < LACK_OF_FIT_ALPHA / len(fits))
    ]
    return sorted(bad, key=lambda fit: -fit.worst_n)


def misfit_sentences(fits: Sequence[AffineFit]) -> list[str]:
    """The largest residual of each channel, worst first; channels of which the same holds once."""
    alike: dict[str, list[str]] = {}
    for fit in fits:
        alike.setdefault(_misfit(fit), []).append(fit.channel)
    texts = [f"{', '.join(channels)}: {text}" for text, channels in alike.items()]
    more = sum(len(channels) for channels in list(alike.values())[_MOST_MISFITS:])
    rest = [f"{plural(more, 'more channel')} with smaller errors: see the calibration table."]
    return [*texts[:_MOST_MISFITS], *(rest if more else [])]


def _misfit(fit: AffineFit) -> str:
    """The largest residual of a channel, in N and percent of its load."""
    at = int(np.argmax(np.abs(fit.residual_n)))
    load = float(fit.load_n[at])
    share = f" ({100 * abs(fit.residual_n[at]) / load:.0f} % of the load)" if load else ""
    text = f"{number(fit.residual_n[at], 2)} N at {number(load, 3)} N{share}"
    if fit.lack_of_fit is not None:
        text += f", lack of fit p = {number(fit.lack_of_fit.p, 1)}"
    return text


def curvature_sentence(fits: Sequence[AffineFit], curvature: Curvature | None) -> str | None:
    """What the channels' bends say together, None where chance alone would make them agree."""
    if curvature is None or curvature.same_sign != len(curvature.bows):
        return None
    if not curvature.sign_p < _CHANCE:
        return None
    if any(fit.lack_of_fit is not None for fit in fits):
        return (
            f"The curvature has the same sign in all {len(curvature.bows)} channels "
            f"(sign test p = {curvature.sign_p:.3f})."
        )
    return (
        f"The curvature has the same sign in all {len(curvature.bows)} channels (sensitivity "
        f"{'falls' if curvature.mean > 0 else 'rises'} with load; mean bow "
        f"{100 * curvature.mean:.1f} % of the span, sign test p = {curvature.sign_p:.3f}): a "
        "shared cause, not noise of single channels. Without repeated loads it is unknown "
        "whether that is nonlinearity, creep or the order of loading."
    )


_ATTENUATED = 0.002


def moving_findings(study: ChannelStudy) -> Iterator[Finding]:
    """What a reference that never stands still means for a channel."""
    if not study.lags_s:
        return
    lags = ", ".join(f"{1e3 * lag:.3g}" for lag in study.lags_s)
    yield Finding(
        "moving_reference", "note", study.channel,
        f"the reference never stands still: compared sample by sample, the reading {lags} ms late",
        "nothing to do: the lag is taken out",
    )  # fmt: skip
    if study.attenuation > _ATTENUATED:
        yield Finding(
            "noisy_regressor", "warning", study.channel,
            f"noise pulls the scale towards zero by up to {100 * study.attenuation:.2g} %",
            "record slower or longer ramps, or hold the load",
        )  # fmt: skip


def find_extrapolation(
    fits: Sequence[AffineFit], intended_load_n: tuple[float, float] | None
) -> list[Finding]:
    """A finding where cells are meant to carry more than they were loaded with."""
    if intended_load_n is None:
        return []
    highest = min(float(fit.load_n.max()) for fit in fits)
    intended = intended_load_n[1]
    if intended <= highest:
        return []
    return [
        Finding(
            "extrapolation", "warning", "all channels",
            f"cells are meant to carry {intended:.4g} N, but the largest load was {highest:.4g} N "
            f"({intended / highest:.1f} times smaller)",
            "add weights up to the intended load; above the fitted range errors are unknown",
        )
    ]  # fmt: skip


def scale_unit(fits: Sequence[AffineFit]) -> tuple[float, str]:
    """Factor and unit in which the scales of a page are read."""
    return display_unit("N/count", [fit.scale_n_per_count for fit in fits])


def parameter_sheet(fits: Sequence[AffineFit]) -> Sheet:
    """Scale, bias and errors of each channel."""
    factor, unit = scale_unit(fits)
    rows = [
        (
            fit.channel,
            with_sd(factor * fit.scale_n_per_count, factor * float(fit.estimates.sd[0])),
            with_sd(fit.bias_n, float(fit.estimates.sd[1])),
            f"{fit.zero_counts:,.0f}",
            number(fit.centre_sd_n, 2),
            number(fit.rmse_n, 3),
            number(fit.worst_n, 3),
            number(fit.smallest_step_n, 2) if fit.smallest_step_n > _COARSE * fit.rmse_n else "–",
            f"{number(float(fit.load_n.min()), 3)} … {number(float(fit.load_n.max()), 3)}",
            f"{fit.load_n.size:,}",
        )
        for fit in fits
    ]
    return Sheet(
        "Calibration",
        ("channel", f"scale ({unit})", "bias (N)", "zero at (counts)", "sd at mid-load (N)",
         "RMSE (N)", "worst (N)", "smallest step (N)", "loads (N)", "n"),
        rows,
        brief=("channel", f"scale ({unit})", "bias (N)", "RMSE (N)", "worst (N)"),
        note="± is one standard deviation from the residuals of the fit; parameters.json has the "
        "covariance of scale and bias, which are nearly collinear at these readings.",
    )  # fmt: skip


def residual_sheet(fits: Sequence[AffineFit]) -> Sheet:
    """Error of the affine fit at every reading, or per load where loads repeat a lot."""
    if sum(fit.load_n.size for fit in fits) > _MOST_READINGS:
        return _residuals_by_load(fits)
    every = [(fit.channel, *row) for fit in fits
             for row in zip(fit.load_n, fit.counts, fit.residual_n, strict=True)]  # fmt: skip
    errors = with_same_decimals([row[3] for row in every])
    shares = with_same_decimals([100 * row[3] / row[1] if row[1] else np.nan for row in every], 2)
    rows = [
        (channel, number(load, 4), f"{counts:,.0f}", error, share)
        for (channel, load, counts, _), error, share in zip(every, errors, shares, strict=True)
    ]
    return Sheet(
        "Residuals",
        ("channel", "load (N)", "counts", "measured − known (N)", "% of load"),
        rows,
        note="Residual of the affine fit.",
    )


def _residuals_by_load(fits: Sequence[AffineFit]) -> Sheet:
    every = []
    for fit in fits:
        level = load_levels(fit.load_n)
        for k in range(int(level.max()) + 1):
            at = level == k
            if not at.any():
                continue
            load, error = float(fit.load_n[at].mean()), fit.residual_n[at]
            spread = float(error.std(ddof=1)) if error.size > 1 else float("nan")
            every.append((fit.channel, load, error.size, float(error.mean()), spread))
    means = with_same_decimals([row[3] for row in every])
    spreads = with_same_decimals([row[4] for row in every])
    shares = with_same_decimals([100 * row[3] / row[1] if row[1] else np.nan for row in every], 2)
    rows = [
        (channel, number(load, 4), str(n), mean, spread, share)
        for (channel, load, n, *_), mean, spread, share in zip(
            every, means, spreads, shares, strict=True
        )
    ]
    more = f" The first {_MOST_ROWS} of {len(rows)} rows." if len(rows) > _MOST_ROWS else ""
    return Sheet(
        "Residuals by load",
        ("channel", "load (N)", "n", "mean (N)", "sd (N)", "mean, % of load"),
        rows[:_MOST_ROWS],
        note=f"Residual of the affine fit, measured − known.{more}",
    )


def method_sheet(fits: Sequence[AffineFit]) -> Sheet:
    """Ordinary, weighted and robust scales side by side, and the tests of the straight line."""
    factor, unit = scale_unit(fits)
    rows = []
    for fit in fits:
        scales = [
            fit_affine(fit.channel, fit.load_n, fit.counts, method).scale_n_per_count
            for method in ("ordinary", "weighted", "robust")
        ]
        test = fit.lack_of_fit
        rows.append(
            (
                fit.channel,
                *(number(factor * scale, 6) for scale in scales),
                f"{100 * fit.bow:.2f}",
                number(test.f, 3) if test else "no repeats",
                number(test.p, 2) if test else "–",
            )
        )
    return Sheet(
        "Checks of the model",
        ("channel", f"ordinary ({unit})", "weighted", "robust", "bow (% of span)",
         "lack of fit F", "p"),
        rows,
        note="Where ordinary, weighted and robust scales differ by more than their sd, single "
        "readings drive the fit.",
    )  # fmt: skip


def force_row(channel: str, stage: str, errors: FloatArray, split: Split = "all") -> RmseRow:
    """Root mean square of a channel's force error."""
    return RmseRow.of(f"force {channel}", "N", stage, "known load", errors, split)


def affine_rows(fits: Sequence[AffineFit], after: str = "after") -> list[RmseRow]:
    """Errors before and after; before: all cells alike, each with its own zero reading."""
    common = float(np.median([fit.scale_n_per_count for fit in fits]))
    rows = []
    for fit in fits:
        unloaded = fit.counts[np.argmin(np.abs(fit.load_n))]
        rows.append(force_row(fit.channel, "before", common * (fit.counts - unloaded) - fit.load_n))
        rows.append(force_row(fit.channel, after, fit.residual_n))
    rows.append(force_row("all", after, np.concatenate([fit.residual_n for fit in fits])))
    return rows
