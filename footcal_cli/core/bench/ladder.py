"""The ladder of channel models: climbed only where left-out sessions or loads pay for it.

From the affine model upwards the rung that helps held-out groups most is taken, if the one-
standard-error rule prefers it to staying, its sizes differ from zero and it predicts the held-out
groups better than staying does; then the remaining rungs are tried on top of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footcal_cli.core.bench.channel import ChannelFit, fit_channel
from footcal_cli.core.bench.record import BenchRecord
from footcal_cli.core.bench.terms import Rung, Term, menu
from footcal_cli.core.inference.held_out import TIE, HeldOut, choose, hold_out
from footcal_cli.core.parameters import BoolArray, FloatArray
from footcal_cli.errors import FitError

ALPHA = 0.01
"""A rung whose parameters are not significant at this level is left out, however well it predicts.

Shared out over the rungs tried on top of a model (Bonferroni): the best of ten is not one of ten.
"""
_MOST_STEPS = 3


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
        On left-out groups, each predicted by a fit without it.
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


def climb(
    record: BenchRecord, rungs: tuple[Rung, ...] | None = None, alpha: float = ALPHA
) -> Ladder:
    """Choose a channel's model on held-out sessions (three or more) or loads.

    Parameters
    ----------
    record
        Rows of one channel.
    rungs
        Extensions to try; all the record could support where absent.
    alpha
        Level of the test that a rung's sizes are zero.
    """
    rungs = menu(record) if rungs is None else rungs
    affine = fit_channel(record)
    here, here_out = affine, held_out_error(record, affine)
    rows = [_row("affine", affine, here_out, None, True, "the start")]
    taken: list[Rung] = []
    rivals: tuple[str, ...] = ()
    left = list(rungs)
    for _ in range(_MOST_STEPS):
        # on top of a rung, only what its own data call significant is worth the held-out fits
        level = alpha if taken else 1.0
        attempts = (_try(record, taken, rung, level) for rung in left)
        tried = [item for item in attempts if item is not None]
        if not tried:
            break
        p_values = [_added_p(fit, rung) for rung, fit, _ in tried]
        strict = alpha / len(tried)
        # the rule compares with the best rung of all; none is climbed to predict worse than before
        significant = [
            i
            for i, p in enumerate(p_values)
            if p < strict and _predicts_better(tried[i][2], here_out)
        ]
        # of rivals with as many numbers the better fit is the simpler explanation: with few groups
        # it says more than their nearly equal held-out errors
        by_fit = np.argsort(np.argsort([fit.rmse_n for _, fit, _ in tried])) / (len(tried) + 1)
        choice = choose(
            [here_out, *(tried[i][2] for i in significant)],
            [0.0, *(float(tried[i][0].cost + by_fit[i]) for i in significant)],
        )
        step = significant[choice.chosen - 1] if choice.chosen > 0 else -1
        rows += [
            _row(
                " + ".join(r.name for r in (*taken, rung)),
                fit,
                out,
                here_out,
                i == step,
                _why(i, step, p_values[i], strict),
                p_values[i],
            )
            for i, (rung, fit, out) in enumerate(tried)
        ]
        if step < 0:
            break
        if not taken:
            rivals = _rivals(tried, significant, step)
        rung, here, here_out = tried[step]
        taken.append(rung)
        left = [other for other in left if not _same_family(other, rung)]
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


def _predicts_better(one: HeldOut, other: HeldOut) -> bool:
    """Whether the mean squared error is smaller, over rows and with every group counting alike."""
    over_groups = float(one.mse_by_group().mean()) < float(other.mse_by_group().mean())
    return over_groups and one.rmse < other.rmse


def _rivals(
    tried: list[tuple[Rung, ChannelFit, HeldOut]], significant: list[int], step: int
) -> tuple[str, ...]:
    """Significant rungs of another kind, no more complex, within one standard error or a tie."""
    chosen, _, chosen_out = tried[step]
    found = []
    for i in significant:
        rung, _, out = tried[i]
        if i == step or rung.cost > chosen.cost or _same_family(rung, chosen):
            continue
        difference = out.mse_by_group() - chosen_out.mse_by_group()
        spread = float(difference.std(ddof=1)) / np.sqrt(difference.size)
        if difference.mean() <= max(spread, TIE * float(chosen_out.mse_by_group().mean())):
            found.append(rung.name)
    return tuple(found)


def promising(record: BenchRecord, alpha: float = ALPHA) -> bool:
    """Whether a rung's sizes differ from zero in the fit to all rows: else `climb` takes none.

    A tenth of the work of `climb`, which predicts left-out groups with every rung.
    """
    fits = [(rung, _fitted(record, [], rung)) for rung in menu(record)]
    p_values = [_added_p(fit, rung) for rung, fit in fits if fit is not None]
    return any(p < alpha / len(p_values) for p in p_values)


def _fitted(record: BenchRecord, taken: list[Rung], rung: Rung) -> ChannelFit | None:
    """A rung on top of those taken; None where the record is too short."""
    terms: tuple[Term, ...] = tuple(term for r in (*taken, rung) for term in r.terms)
    try:
        return fit_channel(record, terms)
    except FitError:
        return None


def _try(
    record: BenchRecord, taken: list[Rung], rung: Rung, level: float
) -> tuple[Rung, ChannelFit, HeldOut] | None:
    """A rung on top of those taken; None where the record is too short or p reaches `level`."""
    fit = _fitted(record, taken, rung)
    if fit is None or not _added_p(fit, rung) <= level:
        return None
    try:
        return rung, fit, held_out_error(record, fit)
    except FitError:
        return None


def _added_p(fit: ChannelFit, rung: Rung) -> float:
    """p-value of the sizes that the last rung added."""
    return fit.p_value_of(range(len(fit.terms) - len(rung.terms), len(fit.terms)))


def _same_family(one: Rung, other: Rung) -> bool:
    """Whether two rungs share a kind of term, so that both together would be redundant."""
    kinds = [{term.size.split("_")[0] for term in rung.terms} for rung in (one, other)]
    return bool(kinds[0] & kinds[1])


def _why(index: int, step: int, p: float, alpha: float) -> str:
    if index == step:
        return "chosen: one-standard-error rule on held-out groups"
    if p >= alpha:
        return f"not significant (p > {alpha:.2g})"
    if step < 0:
        return "not better than the simpler model by one standard error"
    return "more complex or larger held-out error than the chosen model"


def _row(
    model: str,
    fit: ChannelFit,
    out: HeldOut,
    before: HeldOut | None,
    climbed: bool,
    why: str,
    p_value: float = np.nan,
) -> LadderRow:
    gain = np.zeros(1) if before is None else before.mse_by_group() - out.mse_by_group()
    spread = gain.std(ddof=1) / np.sqrt(gain.size) if gain.size > 1 else 0.0
    return LadderRow(
        model=model,
        coefficients=fit.linear.size,
        rmse_n=fit.rmse_n,
        held_out_rmse_n=out.rmse,
        gain_n2=float(gain.mean()),
        gain_sd_n2=float(spread),
        p_value=p_value,
        climbed=climbed,
        why=why,
    )
