"""What every refit of a diagnosis is about, and the arrays of a model with effects in it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from footcal_cli.core.diagnosis.answer import Cause
from footcal_cli.core.diagnosis.bridge import (
    Describe,
    calibration_at,
    held_of,
    known_of,
    problem_from,
)
from footcal_cli.core.diagnosis.zeros import changed, is_zero, zero_columns
from footcal_cli.core.effects.contract import Effect, Trait
from footcal_cli.core.inference.case import Case, residual
from footcal_cli.core.inference.linear import unit_columns
from footcal_cli.core.inference.noise_credit import shrinkage
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.refit import Refit, refit
from footcal_cli.core.inference.signatures import derivative
from footcal_cli.core.parameters import FloatArray

Advance = Callable[[float], None]
_BENT = 0.02
"""Change of the residual that a linear step of the calibration misses, over what is left."""
_REFITS_KEPT = 4  # a refit holds a copy of the recordings


def uncounted(_: float) -> None:
    """Nobody watches how far it is."""


@dataclass(eq=False)
class Subject:
    """What every refit of a diagnosis is about; remembers the last ones.

    Parameters
    ----------
    case, problem
        The recordings with the baseline, and that in arrays.
    table
        Effects by name.
    describe
        Gives the recorded signals of a case.
    advance
        Called with how many more refits are done.
    """

    case: Case
    problem: Problem
    table: Mapping[str, Effect]
    describe: Describe
    advance: Advance = uncounted
    _refits: dict[tuple[object, ...], Refit] = field(default_factory=dict, init=False, repr=False)
    _zeros: dict[str, FloatArray] = field(default_factory=dict, init=False, repr=False)
    _whole: dict[int, tuple[Refit, Problem]] = field(default_factory=dict, init=False, repr=False)

    def refitted(self, causes: Sequence[Cause], start: Mapping[str, float]) -> Refit:
        """The model with all of these causes, from starting values; the last ones are kept.

        A pair of causes is looked for beside each of them alone, which were refitted before.
        """
        self.advance(1)
        key = (
            *(cause.signature for cause in causes),
            *((name, f"{value:.9g}") for name, value in sorted(start.items())),
        )
        if key not in self._refits:
            if len(self._refits) == _REFITS_KEPT:
                del self._refits[next(iter(self._refits))]
            self._refits[key] = self._refitted(causes, start)
        return self._refits[key]

    def refitted_from(self, causes: Sequence[Cause], fitted: Refit) -> Refit:
        """The model with some of the causes of another one, from the values they have there."""
        names = {p.name for c in causes for p in self.table[c.signature.effect].parameters}
        start = {
            n: v for n, v in fitted.values.items()
            if n not in self.case.values and n.rsplit(".", 1)[1] in names
        }  # fmt: skip
        return self.refitted(causes, start)

    def _refitted(self, causes: Sequence[Cause], start: Mapping[str, float]) -> Refit:
        accepted = [(self.table[c.signature.effect], c.signature) for c in causes]
        problem = self.problem.without_usual({effect.name for effect, _ in accepted})
        problem = problem.asking(accepted=self._beside_zeros(causes))
        model = refit(self.case, problem, accepted, start)
        if problem.calibration_turn is None or problem.known is not None or problem.drifts:
            return model
        # what is wrong has moved the calibration, in whose units its size then is
        left, *_ = np.linalg.lstsq(problem.calibration, model.residual)
        values, change = dict(self.case.values), problem.calibration_turn @ left
        for parameter, by in zip(self.case.calibration, change.tolist(), strict=True):
            values[parameter.name] = values.get(parameter.name, parameter.value) - by
        begun = {n: v for n, v in model.values.items() if n not in self.case.values}
        linear = model.residual - problem.calibration @ left
        bent = residual(self.case, self.problem, {**values, **begun}, model.chain) - linear
        if np.sqrt(np.mean(bent**2)) < _BENT * np.sqrt(np.mean(linear**2)):
            return model
        return refit(replace(self.case, values=values), problem, accepted, begun)

    def extended(self, model: Refit, causes: Sequence[Cause]) -> Problem:
        """The problem on the extended model: its effects and their rivals are calibration now.

        Calibration and candidates are differentiated anew. A gain beside a curve is not the gain
        that it was without, and signatures taken where the effect was still an error share the
        noise with the residual.
        """
        rest = self._on(model, causes).without(*(c.signature.effect for c in causes))
        return rest.asking(accepted=self._accepted(model, causes))

    def _on(self, model: Refit, causes: Sequence[Cause]) -> Problem:
        """The problem on a model; of its causes' own effects, imperfections alone are candidates.

        These, and what they cover, say which of them are usual.
        """
        if id(model) not in self._whole:
            case = self.case.extended(model.chain, model.values)
            usual = case.experiment.imperfections
            named = {c.signature.effect for c in causes}
            named -= {name for item in usual for name in (item.effect.name, *item.covers)}
            effects = [effect for name, effect in self.table.items() if name not in named]
            turn = self.problem.calibration_turn
            made = problem_from(case, self.problem, effects, self.describe, turn, model.ideal)
            self._whole.clear()
            self._whole[id(model)] = model, made
        return self._whole[id(model)][1]

    def beside_usual(self, model: Refit, causes: Sequence[Cause]) -> Refit:
        """The model beside imperfections that are of usual size only with its causes in it."""
        whole, known = self._on(model, causes), set(self.problem.usual_of)
        if known.issuperset(whole.usual_of):
            return model
        accepted = [(self.table[c.signature.effect], c.signature) for c in causes]
        problem = replace(
            self.problem, usual=whole.usual, usual_of=whole.usual_of,
            accepted=self._beside_zeros(causes),
        )  # fmt: skip
        start = {n: v for n, v in model.values.items() if n not in self.case.values}
        self.advance(1)
        return refit(self.case, problem, accepted, start)

    def bare(self, model: Refit, causes: Sequence[Cause]) -> Problem:
        """As `extended`, without candidates."""
        within = self.problem.calibration_turn
        calibration, turn = calibration_at(model.judged, self.problem, within)
        return replace(
            self.problem.without_usual({c.signature.effect for c in causes}),
            residual=model.residual,
            calibration=calibration,
            calibration_turn=turn,
            known=known_of(self.case, turn),
            held=held_of(model.judged, self.problem),
            accepted=self._accepted(model, causes),
            columns=self.problem.columns[:, :0],
            signatures=(),
        )

    def columns(self, ideal: Case, signatures: Iterable[Signature]) -> list[FloatArray]:
        """What each signature of size one adds to recordings without noise, (m,) each."""
        seen, found = ideal.memory(), []
        for signature in signatures:
            effect = self.table[signature.effect]
            size = next(p for p in effect.sizes if p.name == signature.parameter)
            owners, shape = dict(signature.owners), dict(signature.shape)
            found.append(derivative(ideal, self.problem, effect, size, owners, shape, seen=seen))
        return found

    def beside(self, model: Refit, signatures: Iterable[Signature]) -> FloatArray:
        """What candidates would add to an extended model, at unit RMS, shape (m, k)."""
        taken = {(link.effect.name, owner) for link in model.chain.links for owner in link.owners}
        new = [
            signature for signature in dict.fromkeys(signatures)
            if not any((signature.effect, owner) in taken for owner, _ in signature.owners)
        ]  # fmt: skip
        remembers = any(Trait.MEMORY in self.table[s.effect].traits for s in new)
        columns = self.columns(model.ideal if remembers else model.judged, new)
        return unit_columns(np.stack(columns, axis=1) if columns else model.columns[:, :0])

    def without_credit(self, extended: Problem, fitted: Refit) -> Problem:
        """The extended problem in rows of equal noise: no model has credit for making it small."""
        return extended.scaled(shrinkage(self.case, self.problem, fitted.chain, fitted.values))

    def _accepted(self, model: Refit, causes: Sequence[Cause]) -> FloatArray:
        """Columns of the effects in the model, their rivals and their zeros, shape (m, a)."""
        rivals = [s for c in causes for s in (*c.rivals, *c.places)]
        columns = unit_columns(model.columns), self.beside(model, rivals)
        return np.hstack([*columns, *self._changed_zeros(causes)])

    def zero(self, owner: str) -> FloatArray:
        """What the zero of an owner does to the residual where hanging knows it, shape (m, z)."""
        if owner not in self._zeros:
            self._zeros[owner] = zero_columns(self.case, self.problem, owner)
        return self._zeros[owner]

    def zero_is_named(self, causes: Sequence[Cause]) -> bool:
        """Whether a cause is nothing but the zero that another one of them has changed.

        What is left of its size is then where a free zero is not quite a straight line. Where six
        sums are balanced, one leg's free zero is a shift of all legs, or of another one, as well.
        """
        return any(
            is_zero(self.problem, self.zero(owner), cause.signature)
            for owner in changed(self.table, causes) for cause in causes
        )  # fmt: skip

    def _beside_zeros(self, causes: Sequence[Cause]) -> FloatArray | None:
        """What is fitted beside a model of causes: zeros that they have changed."""
        zeros = self._changed_zeros(causes)
        return np.hstack(zeros) if zeros else self.problem.accepted

    def _changed_zeros(self, causes: Sequence[Cause]) -> list[FloatArray]:
        return [self.zero(owner) for owner in changed(self.table, causes)]
