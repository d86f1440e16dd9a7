"""The ladder of channel models: climbed only where left-out sessions or loads pay for it.

Upwards from the affine model: of rungs whose sizes differ from zero, the one that helps left-out
groups most is taken, if the one-standard-error rule prefers it to staying and it predicts these
groups better than staying does; then the remaining rungs are tried on top of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footcal_cli.core.bench.channel import ChannelFit, fit_channel
from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.bench.terms import Rung, Term, menu
from footcal_cli.core.inference.held_out import TIE, HeldOut, choose, hold_out
from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.errors import FitError

ALPHA = 0.01
"""A rung whose parameters are not significant at this level is left out, however well it predicts.

Shared out over the rungs tried on top of a model and the cells of a bench (Bonferroni): the best
of ten is not one of ten.
"""
_MOST_STEPS = 3
_LEAST_EXPLAINED = 0.5
_OF_ANOTHER = "leaves most of what the line misses: it is the form of something else"


@dataclass(frozen=True)
class LadderRow:
    """One model tried, and what it was worth on groups it had not seen.

    Parameters
    ----------
    model
        ``affine`` or the names of its rungs joined by `` + ``.
    rmse_n
        On the rows it was fitted to.
    held_out_rmse_n
        On left-out groups, each predicted by a fit without it; NaN where a rung is not significant,
        which is not taken however well it predicts.
    gain_n2, gain_sd_n2
        Mean squared error of the model it extends minus its own, over groups, and the standard
        error of that difference.
    p_value
        That all added sizes are zero.
    climbed
        Whether the ladder took it.
    why
        Reason for taking or leaving it.
    """

    model: str
    coefficients: int
    rmse_n: float
    held_out_rmse_n: float
    gain_n2: float
    gain_sd_n2: float
    p_value: float
    climbed: bool
    why: str


@dataclass(frozen=True)
class Ladder:
    """All models tried on one channel.

    Parameters
    ----------
    rows
        In the order in which they were tried.
    affine, chosen
        The straight line, and the model the evidence supports.
    rungs
        Names of the rungs of `chosen`; empty for the affine model.
    rivals
        Rungs with no more numbers than the first one climbed that predict as well: another cause
        that these data cannot exclude.
    groups
        Units of evidence: number of sessions or loads.
    by_session
        Whether the groups were sessions; else loads.
    held_out
        Errors of the chosen model on left-out groups.
    """

    channel: str
    rows: tuple[LadderRow, ...]
    affine: ChannelFit
    chosen: ChannelFit
    rungs: tuple[str, ...]
    rivals: tuple[str, ...]
    groups: int
    by_session: bool
    held_out: HeldOut

    @property
    def model(self) -> str:
        """Name of the chosen model."""
        return " + ".join(self.rungs) or "affine"

    @property
    def affine_scale_error(self) -> float:
        """Relative error of the affine scale if the chosen model is true."""
        name = f"{self.channel}.scale"
        return self.affine.estimates[name] / self.chosen.estimates[name] - 1.0

    @property
    def affine_bias_error_n(self) -> float:
        """Error of the load that the affine model reads at the centre of its readings."""
        shift = self.affine.linear[0] * (self.chosen.centre - self.affine.centre)
        return float(self.affine.linear[1] + shift - self.chosen.linear[1])


@dataclass(frozen=True)
class _Attempt:
    """A rung on top of those taken, and its errors on left-out groups if it is significant.

    Parameters
    ----------
    level
        A p-value below it is significant.
    """

    rung: Rung
    fit: ChannelFit
    p_value: float
    level: float
    out: HeldOut | None

    @property
    def errors(self) -> HeldOut:
        """On left-out groups, of a significant rung."""
        assert self.out is not None
        return self.out


def held_out_error(record: BenchRecord, fit: ChannelFit) -> HeldOut:
    """Errors of a model on groups left out one after the other.

    The loads of a left-out group are withheld from the regression; its readings stay, because a
    model with memory must live through them. Shapes are searched again near the full fit's.

    Parameters
    ----------
    fit
        The model fitted to all of them.
    """
    known = record.known
    group = record.groups()[known]

    def predict(out: BoolArray) -> FloatArray:
        withheld = np.zeros(len(record), dtype=bool)
        withheld[np.flatnonzero(known)[out]] = True
        part = record.without(withheld)
        trained = fit_channel(part, fit.terms, fit.log_shapes, fit.correlation_s)
        return trained.predict(record).load_n[known]

    return hold_out(predict, record.load_n[known], group)


def climb(record: BenchRecord, rungs: tuple[Rung, ...] | None = None, cells: int = 1) -> Ladder:
    """Choose a channel's model on held-out sessions (three or more) or loads.

    Parameters
    ----------
    record
        Rows of one channel.
    rungs
        Extensions to try; all the record could support where absent.
    cells
        Channels of the bench that are searched alike.
    """
    rungs = menu(record) if rungs is None else rungs
    affine = fit_channel(record)
    affine_out = held_out_error(record, affine)
    here, here_out = affine, affine_out
    rows = [
        LadderRow("affine", affine.linear.size, affine.rmse_n, here_out.rmse, 0.0, 0.0, np.nan,
                  True, "the start")
    ]  # fmt: skip
    taken: list[Rung] = []
    rivals: tuple[str, ...] = ()
    left = list(rungs)
    for _ in range(_MOST_STEPS):
        tried = _attempts(record, taken, left, ALPHA / cells)
        if not tried:
            break
        # none is climbed to predict worse than before
        better = [a for a in tried if a.out is not None and _predicts_better(a.out, here_out)]
        # of rivals with as many numbers the better fit is the simpler explanation: with few groups
        # it says more than their nearly equal held-out errors
        by_fit = sorted(a.fit.rmse_n for a in tried)
        choice = choose(
            [here_out, *(a.errors for a in better)],
            [0.0, *(a.rung.cost + by_fit.index(a.fit.rmse_n) / (len(tried) + 1) for a in better)],
        )
        step = better[choice.chosen - 1] if choice.chosen > 0 else None
        rows += [_row(a, taken, here_out, step) for a in tried]
        if step is None:
            break
        if not taken:
            rivals = _rivals(better, step)
        here, here_out = step.fit, step.errors
        taken.append(step.rung)
        left = [other for other in left if not _same_family(other, step.rung)]
    if taken and not _explains(record, affine, affine_out.rmse, here_out.rmse):
        here, here_out, taken, rivals = affine, affine_out, [], ()
        rows[1:] = [
            replace(row, climbed=False, why=_OF_ANOTHER) if row.climbed else row for row in rows[1:]
        ]
    return Ladder(
        channel=record.channel,
        rows=tuple(rows),
        affine=affine,
        chosen=here,
        rungs=tuple(rung.name for rung in taken),
        rivals=rivals,
        groups=int(np.unique(record.groups()[record.known]).size),
        by_session=bool(np.unique(record.session).size >= 3),
        held_out=here_out,
    )


def _explains(record: BenchRecord, affine: ChannelFit, before_n: float, after_n: float) -> bool:
    """Whether a model explains enough of what the line misses beyond how loads repeat.

    ``e₀² − e² ≥ h (e₀² − s²)`` with the errors on left-out groups of the line and the model, and s
    the scatter of the readings of one load. What is left then is no noise, and the little that the
    model takes of it is another cause in its clothes: a wrong weight looks a little like a loop.
    """
    load = record.load_n[record.known]
    _, at = np.unique(load, return_inverse=True)
    error = affine.predict(record).load_n[record.known] - load
    count = np.bincount(at)
    apart = error - (np.bincount(at, error) / count)[at]
    scatter = float(apart @ apart) / max(load.size - count.size, 1)
    return before_n**2 - after_n**2 >= _LEAST_EXPLAINED * (before_n**2 - scatter)


def _predicts_better(one: HeldOut, other: HeldOut) -> bool:
    """Whether the mean squared error is smaller, over rows and with every group counting alike."""
    over_groups = float(one.mse_by_group().mean()) < float(other.mse_by_group().mean())
    return over_groups and one.rmse < other.rmse


def _rivals(better: list[_Attempt], chosen: _Attempt) -> tuple[str, ...]:
    """Rungs of another kind, no more complex, within one standard error of the chosen or a tie."""
    mean = chosen.errors.mse_by_group()
    found = []
    for attempt in better:
        rung = attempt.rung
        if rung.cost > chosen.rung.cost or _same_family(rung, chosen.rung):
            continue
        difference = attempt.errors.mse_by_group() - mean
        spread = float(difference.std(ddof=1)) / np.sqrt(difference.size)
        if difference.mean() <= max(spread, TIE * float(mean.mean())):
            found.append(rung.name)
    return tuple(found)


def promising(record: BenchRecord) -> bool:
    """Whether a rung's sizes differ from zero in the fit to all rows: else `climb` takes none.

    A part of the work of `climb`, which predicts left-out groups with every such rung.
    """
    fitted = _fitted(record, [], menu(record))
    return any(p < ALPHA / len(fitted) for _, _, p in fitted)


def _fitted(
    record: BenchRecord, taken: list[Rung], left: Sequence[Rung]
) -> list[tuple[Rung, ChannelFit, float]]:
    """Each rung on top of those taken that the record is long enough for, and its p-value."""
    found = []
    for rung in left:
        terms: tuple[Term, ...] = tuple(term for r in (*taken, rung) for term in r.terms)
        try:
            fit = fit_channel(record, terms)
        except FitError:
            continue
        found.append((rung, fit, fit.p_value_of(range(len(terms) - len(rung.terms), len(terms)))))
    return found


def _attempts(
    record: BenchRecord, taken: list[Rung], left: Sequence[Rung], alpha: float
) -> list[_Attempt]:
    """What is tried on top of the rungs taken: above the first, only what is significant alone.

    Left-out groups are predicted where a rung is significant among all that are tried.
    """
    fitted = [one for one in _fitted(record, taken, left) if not taken or one[2] <= alpha]
    attempts = []
    for rung, fit, p in fitted:
        level, out = alpha / len(fitted), None
        if p < level and fit.possible:
            try:
                out = held_out_error(record, fit)
            except FitError:
                continue
        attempts.append(_Attempt(rung, fit, p, level, out))
    return attempts


def _same_family(one: Rung, other: Rung) -> bool:
    """Whether two rungs share a kind of term, so that both together would be redundant."""
    kinds = [{term.size.split("_")[0] for term in rung.terms} for rung in (one, other)]
    return bool(kinds[0] & kinds[1])


def _row(attempt: _Attempt, taken: list[Rung], before: HeldOut, step: _Attempt | None) -> LadderRow:
    gain = np.full(1, np.nan)
    if attempt.out is not None:
        gain = before.mse_by_group() - attempt.out.mse_by_group()
    if attempt is step:
        why = "chosen: one-standard-error rule on held-out groups"
    elif attempt.out is None:
        why = f"not significant (p > {attempt.level:.2g})"
        if not attempt.fit.possible:
            why = "a size that no cell can have"
    elif step is None:
        why = "not better than the simpler model by one standard error"
    else:
        why = "more complex or larger held-out error than the chosen model"
    return LadderRow(
        model=" + ".join(r.name for r in (*taken, attempt.rung)),
        coefficients=attempt.fit.linear.size,
        rmse_n=attempt.fit.rmse_n,
        held_out_rmse_n=np.nan if attempt.out is None else attempt.out.rmse,
        gain_n2=float(gain.mean()),
        gain_sd_n2=float(gain.std(ddof=1) / np.sqrt(gain.size)) if gain.size > 1 else 0.0,
        p_value=attempt.p_value,
        climbed=attempt is step,
        why=why,
    )
