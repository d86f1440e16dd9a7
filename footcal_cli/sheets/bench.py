"""`offline-fit`: the report on channels with their weights, and all parts as one report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footcal_cli.core.bench.changes import ParameterChange, find_parameter_changes
from footcal_cli.core.bench.plateaus import SampleState
from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.bench.regression import AffineFit, pooled_curvature
from footcal_cli.core.bench.study import ChannelStudy, record_of_samples
from footcal_cli.core.parameters import Estimates
from footcal_cli.core.quality import Finding
from footcal_cli.core.signals import parts_of
from footcal_cli.plots.ladder import plot_ladder, plot_recordings, plot_staircases
from footcal_cli.plots.weights import (
    mean_residuals,
    plot_loads_against_counts,
    plot_residuals,
    plot_scales,
)
from footcal_cli.records.results import ParametersRecord, RmseRecord, RmseRow, VerdictRecord
from footcal_cli.report import Picture, number, plural
from footcal_cli.report.outcome import Outcome
from footcal_cli.sheets import ladder, weights
from footcal_cli.sheets.weights import scale_unit
from footcal_cli.tables.logfiles import write_parquet_pieces

_LEVELS = ("good", "warning", "bad")
_MOST_CHANGES = 6
_MOST_AT_ONCE = 500_000
"""Rows that a model with memory predicts: 14 arrays and more as long, for a day at 80 Hz 2 GB."""


def joined(
    title: str, parts: Sequence[Outcome], earlier: ParametersRecord | None,
    estimates: Iterable[Estimates],
) -> Outcome:  # fmt: skip
    """All parts as one report, and what has changed since an earlier calibration.

    Parameters
    ----------
    parts
        The one that leads first: its sentence is the verdict, the others are details.
    earlier
        The calibration that the run started from.
    """
    verdicts = [part.verdict for part in parts]
    lead = [sheet for part in parts for sheet in part.leading]
    details = list(verdicts[0].details)
    for verdict in verdicts[1:]:
        details += [verdict.sentence, *verdict.details]
    if earlier is not None and (changes := changes_since(earlier, estimates)):
        since = earlier.created[:10]
        lead.append(ladder.change_sheet(changes, since))
        notable = [c for c in changes if c.p_value < ladder.NOTABLE_P][:_MOST_CHANGES]
        details.append(
            "Changed: " + "; ".join(c.sentence(since) for c in notable) + "."
            if notable
            else f"Nothing changed since {since} beyond what chance explains."
        )
    level = max((verdict.level for verdict in verdicts), key=_LEVELS.index)
    records = [part.rmse for part in reversed(parts) if part.rmse is not None]
    return Outcome(
        title=title,
        verdict=VerdictRecord(
            level=level,
            sentence=verdicts[0].sentence,
            actions=tuple(dict.fromkeys(line for verdict in verdicts for line in verdict.actions)),
            details=tuple(details),
        ),
        pictures=tuple(picture for part in parts for picture in part.pictures),
        lead_sheets=tuple(lead),
        sheets=tuple(sheet for part in parts for sheet in part.details),
        findings=tuple(f for part in parts for f in part.findings),
        footer=tuple(line for part in reversed(parts) for line in part.footer),
        rmse=RmseRecord(
            rows=tuple(row for record in records for row in record.rows),
            rejected={k: n for record in records for k, n in record.rejected.items()},
        ),
        tables={name: table for part in parts for name, table in part.tables.items()},
        files={name: write for part in parts for name, write in part.files.items()},
    )


def changes_since(
    before: ParametersRecord, estimates: Iterable[Estimates]
) -> list[ParameterChange]:
    """Parameters against those of an earlier calibration, the surest change first."""
    known = before.estimates
    found = [change for group in estimates for change in find_parameter_changes(group, known)]
    return sorted(found, key=lambda change: change.p_value)


def weights_outcome(
    studies: Sequence[ChannelStudy],
    apart: Sequence[tuple[ChannelStudy, BenchRecord]],
    findings: Sequence[Finding],
    tolerance_percent: float,
    method: str,
) -> Outcome:
    """Channels with their weights, and records that were kept apart from the fit."""
    fits = [study.affine for study in studies]
    largest = max(float(np.abs(fit.load_n).max()) for fit in fits)
    tolerance_n = tolerance_percent / 100.0 * largest
    curvature = pooled_curvature(fits)
    climbed = any(study.ladder is not None for study in studies)
    extended = any(study.fit is not None for study in studies)
    rows = weights.affine_rows(fits, "affine" if extended else "after")
    if extended:
        rows += [
            weights.force_row(s.channel, "after", s.predict(s.record).load_n - s.record.load_n)
            for s in studies
        ]
    rejected: Counter[str] = Counter()
    for study in studies:
        if study.samples is not None:
            rejected.update(study.samples.rejected())
    sheets = [
        weights.parameter_sheet(fits),
        ladder.model_sheet(studies) if climbed else None,
        ladder.creep_sheet(studies),
        weights.residual_sheet(fits),
        weights.method_sheet(fits),
        ladder.tried_sheet(studies),
    ]
    return Outcome(
        title="Weights",
        verdict=ladder.weights_verdict(studies, curvature, tolerance_n),
        pictures=_pictures(studies, tolerance_n, climbed=climbed),
        sheets=tuple(sheet for sheet in sheets if sheet is not None),
        findings=tuple(findings),
        footer=(
            f"Model: F = scale · S + bias per channel, {method} regression of load on counts "
            "(NAO CoP self-calibration, eqs. 1 and 2). Adequate: no residual above "
            f"{tolerance_percent:g} % of the largest load ({tolerance_n:.3g} N).",
            *_said_of_predictions(studies),
        ),
        rmse=RmseRecord(
            rows=(*rows, *ladder.held_out_rows(studies), *_held_out(apart)), rejected=dict(rejected)
        ),
        files={
            "predictions.parquet": lambda path: write_parquet_pieces(
                _predictions(studies, apart), path
            )
        },
    )


def _largest_mean(fits: Sequence[AffineFit]) -> str:
    """The largest mean residual at any load, and whose it is."""
    means = {fit.channel: float(np.abs(mean_residuals(fit)[1]).max()) for fit in fits}
    worst = max(means, key=means.__getitem__)
    return f"At no load is the mean further off than {number(means[worst], 2)} N ({worst})."


def _pictures(
    studies: Sequence[ChannelStudy], tolerance_n: float, *, climbed: bool
) -> tuple[Picture, ...]:
    recorded = any(study.samples is not None for study in studies)
    recording = Picture(
        "recordings", lambda: plot_recordings(studies),
        "The recording: blue samples were used, the others not, and why.",
        title="Recording, with the samples used and rejected",
        result=lambda: _used(studies), zoom=True,
    )  # fmt: skip
    return (
        *((recording,) if recorded else ()),
        *(_model_pictures(studies) if climbed else ()),
        *_line_pictures([study.affine for study in studies], tolerance_n, residuals=not recorded),
    )


def _model_pictures(studies: Sequence[ChannelStudy]) -> tuple[Picture, ...]:
    """The straight line of each channel against the model that was chosen for it."""
    worst = max((study.affine for study in studies), key=lambda fit: fit.worst_n)
    models = {s.channel: s.ladder.model for s in studies if s.ladder is not None}
    chosen = ", ".join(
        f"{model} in {sum(m == model for m in models.values())}"
        for model in dict.fromkeys(models.values())
    )
    return (
        Picture(
            "staircases", lambda: plot_staircases(studies),
            "Residual against load of the straight line and, where another model was chosen, "
            "of that model below it. A gap between loading and unloading is hysteresis or "
            "creep, a common bend is nonlinearity.",
            title="Residual against known load, loading and unloading",
            result=f"The straight line errs by at most {number(worst.worst_n, 2)} N "
            f"({worst.channel}).",
        ),
        Picture(
            "ladder", lambda: plot_ladder(studies),
            "Error of each model on sessions or loads that it was not fitted to; further left "
            "is better, the filled one is in use.",
            title="Held-out error of each model",
            result=f"Chosen: {chosen} of {plural(len(models), 'channel')}.",
        ),
    )  # fmt: skip


def _line_pictures(
    fits: Sequence[AffineFit], tolerance_n: float, *, residuals: bool
) -> tuple[Picture, ...]:
    """The straight lines of all channels, and their residuals where asked."""
    low, high = (pick(fits, key=lambda fit: abs(fit.scale_n_per_count)) for pick in (min, max))
    left = Picture(
        "residuals", lambda: plot_residuals(fits, tolerance_n),
        "Mean residual at each known load, one line per cell; lines that bend together "
        "share a cause. Blue band: the tolerance.",
        title="Residual of the straight line against known load",
        result=lambda: _largest_mean(fits),
    )  # fmt: skip
    return (
        *((left,) if residuals else ()),
        Picture(
            "loads_against_counts", lambda: plot_loads_against_counts(fits, tolerance_n),
            "Known load against raw reading with the fitted line, and the error below it; orange "
            "channels leave the band.",
            title="Known load against reading, with the fitted line",
            result=f"{_of_all(sum(fit.worst_n > tolerance_n for fit in fits), len(fits))} "
            f"beyond the band of ± {tolerance_n:.3g} N.",
        ),
        Picture("scales", lambda: plot_scales(fits),
                "Cells of one type should have scales that agree.",
            title="Scales of all cells",
            result=_scales(low, high)),
    )  # fmt: skip


def _of_all(some: int, whole: int) -> str:
    """``No channel goes``, ``The only channel goes``, ``2 of 8 channels go``."""
    if not some:
        return "No channel goes"
    if whole == 1:
        return "The only channel goes"
    return f"{some} of {whole} channels {'goes' if some == 1 else 'go'}"


def _scales(low: AffineFit, high: AffineFit) -> str:
    """The smallest and the largest scale."""
    factor, unit = scale_unit((low, high))
    unit = unit.replace("/", " per ")
    one, other = (number(factor * fit.scale_n_per_count, 4) for fit in (low, high))
    if low is high:
        return f"{one} {unit}."
    return f"From {one} ({low.channel}) to {other} {unit} ({high.channel})."


def _used(studies: Sequence[ChannelStudy]) -> str:
    """How many samples of the recordings were used."""
    states = np.concatenate([s.samples.state for s in studies if s.samples is not None])
    used = int(np.sum(states == SampleState.SETTLED))
    return f"{used:,} of {states.size:,} samples were used ({100 * used / states.size:.0f} %)."


def _held_out(apart: Sequence[tuple[ChannelStudy, BenchRecord]]) -> list[RmseRow]:
    """Errors of the channels' models on records that were kept apart."""
    rows = []
    for study, record in apart:
        stages = {"after": study.predict}
        if study.ladder is not None:
            stages = {"affine": study.ladder.affine.predict, **stages}
        for stage, predict in stages.items():
            error = predict(record).load_n - record.load_n
            row = weights.force_row(study.channel, stage, error, "held_out")
            rows.append(row.model_copy(update={"reference": "known load, log never used"}))
    return rows


def _thinning(study: ChannelStudy, rows: int) -> int:
    """Of how many rows one is predicted: a model that remembers needs all of them at once."""
    return -(-rows // _MOST_AT_ONCE) if study.remembers else 1


def _said_of_predictions(studies: Sequence[ChannelStudy]) -> Iterator[str]:
    """What is left out of the predictions."""
    rows = [(len(record_of_samples(study)), study) for study in studies]
    for samples, steps in sorted({(n, _thinning(study, n)) for n, study in rows}):
        if steps > 1:
            yield (
                f"predictions.parquet holds one of {steps} samples of {samples:,}: where a model "
                "remembers the loads before, the whole recording is predicted at once."
            )


def _predictions(
    studies: Sequence[ChannelStudy], apart: Sequence[tuple[ChannelStudy, BenchRecord]]
) -> Iterator[Mapping[str, NDArray[Any]]]:
    """Every row (of a recording: every sample) with its predicted load, counted or not and why.

    Where the model remembers its loads, of a long recording every so many-th, as `_thinning` says.
    """
    reasons = np.array([state.reason for state in SampleState], dtype=object)
    pairs = [(study, record_of_samples(study), "train") for study in studies]
    pairs += [(study, record, "held_out") for study, record in apart]
    for study, every, split in pairs:
        thinned = slice(None, None, _thinning(study, len(every)))
        whole = every.select(thinned)
        # a model that remembers loads is predicted from the first sample on
        for part in parts_of(len(whole), max(len(whole), 1) if study.remembers else None):
            record = whole.select(part)
            found = study.predict(record)
            words = {"channel": study.channel, "model": study.model, "split": split}
            each = {k: np.full(len(record), word, dtype=object) for k, word in words.items()}
            states = np.full(len(record), SampleState.SETTLED.reason, dtype=object)
            if study.samples is not None and split == "train":
                states = reasons[study.samples.state[thinned][part]]
            yield {
                "channel": each["channel"],
                "session": record.session,
                "time_s": record.time_s if record.timed else np.full(len(record), np.nan),
                "load_n": record.load_n,
                "counts": record.reading,
                "predicted_n": found.load_n,
                "sd_n": found.sd_n,
                "ci95_half_width_n": found.half_width_n(),
                "extrapolated": found.extrapolated,
                "model": each["model"],
                "split": each["split"],
                "state": states,
            }
