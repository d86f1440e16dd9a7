"""Everything the bench says about one channel, from its rows to the model to be used."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import special

from footcal_cli.core.bench.channel import ChannelFit, Prediction, fit_channel
from footcal_cli.core.bench.hands import out_of_step
from footcal_cli.core.bench.ladder import Ladder, climb
from footcal_cli.core.bench.law_of_noise import with_law_of_noise
from footcal_cli.core.bench.moving import never_still, without_lags
from footcal_cli.core.bench.plateaus import (
    PlateauOptions,
    Plateaus,
    SampleState,
    find_plateaus,
    why_no_hold,
)
from footcal_cli.core.bench.record import BenchRecord, condense
from footcal_cli.core.bench.regression import AffineFit, Method, fit_affine
from footcal_cli.core.bench.relaxation import Relaxation, Waiting, fit_relaxation, study_waiting
from footcal_cli.core.bench.terms import menu
from footcal_cli.core.parameters import Estimates, IntArray, Status
from footcal_cli.errors import DataError, FitError

FEWEST_ROWS = 10
"""Below this many rows nothing beyond scale and bias is looked for."""
FEWEST_LOADS = 3
ROWS_FOR_FITS = 400
"""A running recording is condensed to about this many means …"""
LONGEST_S, MOST_ROWS = 30.0, 3000
"""… each over no longer than this, or creep were averaged out; but no more than so many."""
_CHANGED = (0.0, 0.5, 1.0)
"""Shares of a pause without rows after which a load may have been changed."""
_SURELY = 10.0
"""Difference of the logarithms of the likelihood."""
_CREEP_BIC = 10.0
"""A second time constant must lower the BIC by this much."""


@dataclass(frozen=True)
class Asked:
    """What is asked of each of so many cells.

    `extend`: more than scale and bias, with polynomials up to `most_degree`.
    """

    method: Method = "ordinary"
    extend: bool = True
    most_degree: int = 3
    cells: int = 1


_ALL = Asked()


@dataclass(frozen=True)
class Samples:
    """A running recording of one channel and what each sample is good for.

    Parameters
    ----------
    record
        All of them; the load is NaN where it is not known.
    state
        `SampleState`, shape (n,).
    hold
        Index of the load that a settled sample belongs to, −1 elsewhere, shape (n,).
    """

    record: BenchRecord
    state: IntArray
    hold: IntArray
    options: PlateauOptions

    @property
    def good(self) -> BenchRecord:
        """The record without glitches and dropouts: NaN in their place."""
        bad = self.state >= SampleState.GLITCH
        return replace(self.record, reading=np.where(bad, np.nan, self.record.reading))

    @property
    def settled(self) -> BenchRecord:
        """The same with the loads of settled samples alone."""
        return replace(self.good, load_n=np.where(self.hold >= 0, self.record.load_n, np.nan))

    def rejected(self) -> dict[str, int]:
        """Samples per reason for not being used."""
        return {
            state.reason: int(np.sum(self.state == state))
            for state in SampleState
            if state is not SampleState.SETTLED and np.any(self.state == state)
        }


@dataclass(frozen=True)
class ChannelStudy:
    """One channel: the affine fit, the ladder above it, and creep seen in its holds.

    Parameters
    ----------
    record
        Rows that were fitted.
    affine
        Regression of load on counts, as [NAO] has it.
    ladder
        None where the rows are too few for anything else.
    samples
        Of a running recording, else None.
    relaxation, waiting
        Creep within holds and what it does to the scale; None without long holds.
    lags_s
        How late the reading is in each session, where the reference never stands still.
    attenuation
        Share by which noise pulls the scale towards zero there.
    """

    channel: str
    record: BenchRecord
    affine: AffineFit
    ladder: Ladder | None
    samples: Samples | None = None
    relaxation: Relaxation | None = None
    waiting: Waiting | None = None
    lags_s: tuple[float, ...] = ()
    attenuation: float = 0.0

    @property
    def fit(self) -> ChannelFit | None:
        """The model the ladder chose, where it is more than a plain regression.

        That is any rung, and the straight line too where sessions or persistent noise make the
        rows dependent, because its intervals are then the honest ones.
        """
        if self.ladder is None:
            return None
        chosen = self.ladder.chosen
        dependent = chosen.sessions > 1 or chosen.correlation_s > 0 or self.record.renewed
        return chosen if self.ladder.rungs or dependent else None

    @property
    def remembers(self) -> bool:
        """Whether a prediction may need the samples before it: any model beyond a straight line."""
        return self.ladder is not None and bool(self.ladder.chosen.terms)

    @property
    def model(self) -> str:
        """Name of the model in use."""
        return "affine" if self.ladder is None else self.ladder.model

    @property
    def estimates(self) -> Estimates:
        """Parameters to be written, as Gaussian: as wide as Student's 95 % intervals."""
        if self.fit is not None:
            return complete(self.fit)
        found, dof = self.affine.estimates, self.affine.load_n.size - 2
        wider = special.stdtrit(dof, 0.975) / special.ndtri(0.975) if dof > 0 else np.nan
        return replace(found, covariance=wider**2 * found.covariance)

    def predict(self, record: BenchRecord) -> Prediction:
        """Loads by the model in use."""
        if self.ladder is not None:
            return self.ladder.chosen.predict(record)
        affine = self.affine
        load = affine.scale_n_per_count * record.reading + affine.bias_n
        centred = record.reading - affine.centre_counts
        scale_sd, centre_sd = float(affine.estimates.sd[0]), affine.centre_sd_n
        dof = max(affine.load_n.size - 2, 1)
        noise = affine.rmse_n**2 * affine.load_n.size / dof
        sd = np.sqrt((scale_sd * centred) ** 2 + centre_sd**2 + noise)
        low, high = float(affine.load_n.min()), float(affine.load_n.max())
        slack = 0.01 * (high - low)
        beyond = (load < low - slack) | (load > high + slack)
        return Prediction(load, sd, np.full(load.size, float(dof)), beyond)


def complete(fit: ChannelFit) -> Estimates:
    """A fit's parameters with the fixed shapes of its terms, so that an effect can be rebuilt."""
    extra = [
        (f"{fit.channel}{term.owner}.{shape}", unit, grid[0])
        for term in fit.terms
        if not term.free
        for shape, unit, grid in zip(term.shapes, term.shape_units, term.grids, strict=True)
    ]
    found = fit.estimates
    count, total = len(found.names), len(found.names) + len(extra)
    covariance = np.zeros((total, total))
    covariance[:count, :count] = found.covariance
    return Estimates(
        (*found.names, *(name for name, _, _ in extra)),
        (*found.units, *(unit for _, unit, _ in extra)),
        np.concatenate([found.values, [value for _, _, value in extra]]),
        covariance,
        (*found.status, *(Status.FIXED for _ in extra)),
    )


def record_of_samples(study: ChannelStudy) -> BenchRecord:
    """What a study began with: its rows, or all samples of a recording, bad ones blanked."""
    return study.record if study.samples is None else study.samples.good


def settled_like(study: ChannelStudy, record: BenchRecord) -> BenchRecord:
    """Another record of the channel, made comparable: a recording loses its unsettled samples.

    Parameters
    ----------
    study
        Says whether the channel was studied from a recording, and how.
    record
        With known loads.
    """
    if study.samples is None:
        return record
    return _condensed(find_loads(record, study.samples.options, ()).settled)


def study_rows(record: BenchRecord, asked: Asked = _ALL) -> ChannelStudy:
    """Study a channel whose rows, shape (n,), are readings of settled loads."""
    known = record.known
    affine = fit_affine(record.channel, record.load_n[known], record.reading[known], asked.method)
    loads = np.unique(record.load_n[known]).size
    ladder = None
    extend = asked.extend and bool(known.sum() >= FEWEST_ROWS and loads >= FEWEST_LOADS)
    if extend or record.renewed:
        # of three loads one left out leaves a line through two: that is no test of a model
        judged = loads > FEWEST_LOADS or np.unique(record.session[known]).size >= FEWEST_LOADS
        rungs = menu(record, asked.most_degree) if extend and judged else ()
        ladder = climb(record, rungs, asked.cells)
    return ChannelStudy(record.channel, record, affine, ladder)


def study_samples(
    record: BenchRecord,
    asked: Asked = _ALL,
    *,
    options: PlateauOptions | None = None,
    loads_n: Sequence[float] = (),
) -> ChannelStudy:
    """Study a channel from a running recording: find holds, condense, choose a model, see creep.

    Parameters
    ----------
    record
        Samples; where the load is recorded too, its standing still makes a sample settled.
    loads_n
        Loads in the order in which they were put on, where the recording does not have them.

    Raises
    ------
    DataError
        The number of loads found is not the number of loads given, or none is given at all.
    """
    holds = options or PlateauOptions()
    if not len(loads_n) and never_still(record, holds):
        return _study_moving(record, asked, holds)
    samples = find_loads(record, holds, loads_n)
    record = with_law_of_noise(_condensed(samples.settled))
    study = study_rows(record, asked)
    relaxation, waiting = _creep_of(samples)
    return replace(
        _changed_later(study, samples.settled),
        # means of neighbouring samples are no repeats: their scatter is no pure error
        affine=replace(study.affine, lack_of_fit=None),
        samples=samples,
        relaxation=relaxation,
        waiting=waiting,
    )


def _changed_later(study: ChannelStudy, samples: BenchRecord) -> ChannelStudy:
    """The study with loads changed at the beginning, amid or at the end of pauses.

    What a cell remembers of a load depends on how long it stood; where the samples under a hand's
    work are not recorded, nobody knows when it was changed. What the likelihood leaves open widens
    the intervals, as a uniform distribution over it.
    """
    ladder, record, pauses = study.ladder, study.record, samples.pauses()
    pauses = pauses[pauses[:, 1] <= record.time_s.max()]  # what follows the last load shows nothing
    alone = np.unique(record.session).size == 1
    if ladder is None or not ladder.chosen.terms or not pauses.size or not alone:
        return study
    terms, shapes = ladder.chosen.terms, ladder.chosen.log_shapes
    records = [replace(record, changed_s=pauses @ np.array([1.0 - s, s])) for s in _CHANGED]
    fits = [fit_channel(one, terms, shapes) for one in records]
    likely = -np.array([fit.rows * np.log(max(fit.rmse_n, 1e-300)) for fit in fits])
    left = np.flatnonzero(likely > likely.max() - _SURELY)
    middle = int(left[left.size // 2])
    chosen = fits[middle].between(fits[left[0]], fits[left[-1]])
    return replace(study, ladder=replace(ladder, chosen=chosen), record=records[middle])


def _study_moving(record: BenchRecord, asked: Asked, options: PlateauOptions) -> ChannelStudy:
    """Study a channel under a reference that never stands still, its lag taken out."""
    found = without_lags(record, options, max(1, len(record) // ROWS_FOR_FITS))
    study = study_rows(_condensed(found.record), asked)
    shifted = replace(record, load_n=found.record.load_n)
    samples = Samples(shifted, found.state, np.where(found.record.known, 0, -1), options)
    affine = replace(study.affine, lack_of_fit=None)
    return replace(
        study, affine=affine, samples=samples, lags_s=found.lags_s, attenuation=found.attenuation
    )


def _condensed(record: BenchRecord) -> BenchRecord:
    span = float(sum(np.ptp(record.time_s[part]) for part in record.sessions()))
    return condense(record, _interval(span))


def _interval(span_s: float) -> float:
    """Over how many seconds of a recording a mean is taken."""
    return max(min(span_s / ROWS_FOR_FITS, LONGEST_S), span_s / MOST_ROWS, 1e-9)


def find_loads(record: BenchRecord, options: PlateauOptions, loads_n: Sequence[float]) -> Samples:
    """State and load of every sample.

    Raises
    ------
    DataError
        The number of loads found is not the number of loads given, or none is given at all.
    """
    state = np.empty(len(record), dtype=np.int64)
    hold = np.full(len(record), -1, dtype=np.int64)
    first = 0
    for part in record.sessions():
        own = find_plateaus(record.time_s[part], record.reading[part], options)
        steady, stamps, load = own, record.time_s[part], record.load_n[part]
        if np.isfinite(load).all():
            steady = find_plateaus(stamps, load, options.of_loads)
        state[part] = np.where(own.state >= SampleState.GLITCH, own.state, steady.state)
        late = out_of_step(stamps, load, own, options.window_s)
        state[part][late & (state[part] == SampleState.SETTLED)] = SampleState.MOVING
        hold[part] = _levels(steady, first)
        first = int(hold.max()) + 1
    usable = state == SampleState.SETTLED
    if not usable.any():
        why, remedy = why_no_hold(record.time_s, record.reading, options)
        remedy += " in [offline_fit.plateaus]"
        raise DataError(f"no hold was found: {why}", column=record.channel, remedy=remedy)
    hold = np.where(usable, hold, -1)
    load = record.load_n.copy()
    if len(loads_n):
        found = np.unique(hold[hold >= 0])
        if found.size != len(loads_n):
            medians = [f"{np.median(record.reading[hold == h]):.6g}" for h in found[:12]]
            raise DataError(
                f"{found.size} loads stand still in the recording, {len(loads_n)} are given; "
                f"readings of those found: {', '.join(medians)}",
                column=record.channel,
                remedy="correct loads_n or the tolerances in [offline_fit.plateaus]",
            )
        load[usable] = np.asarray(loads_n, dtype=float)[np.searchsorted(found, hold[usable])]
    elif not np.isfinite(load[usable]).any():
        found = np.unique(hold[hold >= 0])
        has_load = np.isfinite(load).any()
        raise DataError(
            "no load is known while the reading stands still" if has_load
            else f"the recording has no load column and no loads are given; holds found: "
            f"{found.size}", column=record.channel,
            remedy='give loads = "… kg" in [offline_fit.plateaus], one per hold in order of time',
        )  # fmt: skip
    return Samples(replace(record, load_n=load), state, hold, options)


def _levels(plateaus: Plateaus, first: int) -> IntArray:
    """Index of the load under each sample, counted on from `first`."""
    if not len(plateaus):
        return np.full(plateaus.hold.size, -1, dtype=np.int64)
    level = np.concatenate([plateaus.level + first, [-1]])
    return np.asarray(level[plateaus.hold], dtype=np.int64)


def _creep_of(samples: Samples) -> tuple[Relaxation | None, Waiting | None]:
    """Time constants of the holds, one or two, and what waiting does to the scale."""
    record, at = samples.record, samples.hold >= 0
    span = float(np.ptp(record.time_s[at]))
    dense = BenchRecord(
        "hold", np.where(at, samples.hold, np.nan), samples.good.reading, record.time_s,
        np.zeros(len(record), dtype=np.int64),
    )  # fmt: skip
    short = condense(dense, _interval(span) / 2.0)
    hold = np.where(short.known, np.nan_to_num(short.load_n, nan=-1.0), -1.0).astype(np.int64)
    found: list[Relaxation] = []
    for constants in (1, 2):
        try:
            found.append(fit_relaxation(short.time_s, short.reading, hold, constants))
        except FitError:
            break
    relaxation = None
    if found:
        better = len(found) == 2 and found[1].bic < found[0].bic - _CREEP_BIC
        relaxation = found[1] if better else found[0]
    final = None if relaxation is None else relaxation.level
    waiting = study_waiting(record.time_s, record.reading, record.load_n, samples.hold, final)
    return relaxation, waiting
