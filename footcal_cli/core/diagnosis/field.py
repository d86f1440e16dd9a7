"""All look-alikes of a cause in refits of their own, judged in one noise, and the best of them.

Of the room of the diagnosis; `footcal_cli.core.diagnosis.comparison` asks.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from footcal_cli.core.diagnosis.answer import Cause, Diagnosis
from footcal_cli.core.diagnosis.contenders import Contender, fit, refitted, with_zeros
from footcal_cli.core.diagnosis.ends import at_an_end
from footcal_cli.core.diagnosis.rivals import (
    SMOOTH,
    Tried,
    left_of,
    said_alike,
    share_for_form,
)
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.subject import Subject
from footcal_cli.core.effects.contract import Effect, GridOf, Trait
from footcal_cli.core.inference.evidence import sign_flip_mean
from footcal_cli.core.inference.grams import calibration_grams
from footcal_cli.core.inference.problem import Problem, Signature
from footcal_cli.core.inference.refit import Refit
from footcal_cli.core.inference.scores import held_out_loss
from footcal_cli.core.inference.whitening import Noise
from footcal_cli.core.parameters import FloatArray


@dataclass(frozen=True)
class Field:
    """What all contenders are judged by.

    Parameters
    ----------
    subject, causes, model
        What is diagnosed, all other causes, and the model with them; None without any.
    signs
        Sign patterns of the blocks.
    noise
        That of the likeliest contender: in noise of their own all models would fit alike.
    family
        What the kind of the named cause and of the best could do, each in every shape.
    """

    subject: Subject
    causes: Sequence[Cause]
    model: Refit | None
    signs: FloatArray
    noise: Noise
    family: Sequence[Signature]

    def judged(self, one: Contender, fair: Problem) -> Tried:
        """A contender with its held-out loss, from rows of equal noise, and what it leaves."""
        cause, fitted, bare = one
        left = left_of(bare, self.subject.beside(fitted, self.family), self.noise, self.signs)
        return Tried(cause, fitted, white_loss(fair, self.noise), bare, *left)

    def judged_anew(self, cause: Cause) -> Tried:
        """A cause in a form that was not tried, refitted."""
        refit = fit(self.subject, self.causes, self.model, cause)
        return self.judged(refit, self.subject.without_credit(refit[2], refit[1]))


def field_of(
    subject: Subject,
    causes: Sequence[Cause],
    model: Refit | None,
    answer: Diagnosis,
    signs: FloatArray,
    rules: Rules,
    failed: Collection[str],
) -> tuple[Field, list[Tried], Tried]:
    """The named cause, its look-alikes and those of a contender that does better; and the best.

    What does better than the named cause need not look like that one's other look-alikes.

    Parameters
    ----------
    failed
        Effects that did not stand their refit: no contenders.
    """
    about = [answer.causes[0]]
    taken = {*failed, *(c.signature.effect for c in causes)}
    fits: list[tuple[Contender, Problem]] = []
    more = refitted(subject, causes, model, answer, about[-1], taken)
    while True:
        fits += [(one, subject.without_credit(one[2], one[1])) for one in more]
        field, tried, best = _judged(subject, causes, model, about, fits, signs, rules)
        taken |= {one[0].signature.effect for one in more}
        more = refitted(subject, causes, model, answer, best.cause, taken)
        if not more:
            break
        about.append(best.cause)
    others = {*failed, about[0].signature.effect, *(c.signature.effect for c in causes)}
    more = with_zeros(subject, causes, model, answer, others, signs)
    whole = _whole_with_zeros(field, more, rules)
    if whole:
        instead = {one[0].signature.effect for one, _ in whole}
        fits = [item for item in fits if item[0][0].signature.effect not in instead]
        fits += whole
        field, tried, best = _judged(subject, causes, model, about, fits, signs, rules)
    tried = [_from_the_bend_of(best, other, field) for other in tried]
    return field, tried, best_of(subject.table, inside(subject, tried), signs, rules)


def _judged(
    subject: Subject,
    causes: Sequence[Cause],
    model: Refit | None,
    about: Sequence[Cause],
    fits: Sequence[tuple[Contender, Problem]],
    signs: FloatArray,
    rules: Rules,
) -> tuple[Field, list[Tried], Tried]:
    """All contenders in the noise of the likeliest, and the best of them."""
    noise = _of_the_likeliest([fair for _, fair in fits])
    family = _family(subject, about, [one[0] for one, _ in fits])
    field = Field(subject, causes, model, signs, noise, family)
    tried = [field.judged(one, fair) for one, fair in fits]
    return field, tried, best_of(subject.table, inside(subject, tried), signs, rules)


def _whole_with_zeros(
    field: Field, more: Sequence[Contender], rules: Rules
) -> list[tuple[Contender, Problem]]:
    """Those that leave nothing with the zero of their transducer free, which is much to be given.

    What still leaves something then is not what is wrong: a free zero takes up part of any cause.
    """
    fits = [(one, field.subject.without_credit(one[2], one[1])) for one in more]
    return [item for item in fits if field.judged(*item).p >= rules.alpha_whole]


def inside(subject: Subject, tried: Sequence[Tried]) -> Sequence[Tried]:
    """Contenders that no bound stops, if any: the size of another one is that of something else."""
    return [t for t in tried if not at_an_end(subject, [t.cause], t.fitted)] or tried


def _from_the_bend_of(best: Tried, other: Tried, field: Field) -> Tried:
    """A contender that bends, begun at the load at which the best one does, if it ends better.

    One curve may have two names: a cell that stops and a hinge that closes. From bends of their own
    their refits may end in two places.
    """
    its, mine = (_bend_of(field.subject, t.cause.signature) for t in (best, other))
    there = other.cause.signature.where == best.cause.signature.where
    if other is best or not (its and mine and there):
        return other
    load = best.fitted.values[f"{best.cause.signature.owners[0][0]}.{its}"]
    begun = replace(other.cause.signature, shape=((mine, load),))
    again = field.judged_anew(replace(other.cause, signature=begun))
    return min(other, again, key=lambda t: float(t.loss.sum()))


def _bend_of(subject: Subject, signature: Signature) -> str:
    """The only shape of a curve, if it is the load at which that one bends."""
    effect = subject.table[signature.effect]
    one = [p.name for p in effect.shapes if p.grid_of is GridOf.LOAD]
    bends = Trait.CURVE in effect.traits and len(effect.shapes) == len(one) == 1
    return one[0] if bends else ""


def best_of(
    table: Mapping[str, Effect],
    tried: Sequence[Tried],
    signs: FloatArray,
    rules: Rules,
) -> Tried:
    """The contender that loses least; before it one of its kind that leaves nothing, if it does.

    One that surely leaves twice as much as the one that loses least leaves something, whatever its
    kind would find; and so does one that undoes a low-pass, in the noise that it has made larger.
    """
    least = min(tried, key=lambda t: float(t.loss.sum()))
    left = float(least.loss.sum())

    def as_good(other: Tried) -> bool:
        if Trait.LOW_PASS in table[other.cause.signature.effect].traits:
            return False
        lost = other.loss - least.loss
        return float(lost.sum()) < left or sign_flip_mean(lost, signs) >= rules.alpha_rival

    whole = [
        t for t in tried
        if t.p >= rules.alpha_whole
        and (t is least or (said_alike(table, least.cause, t.cause) and as_good(t)))
    ]  # fmt: skip
    return min(whole or [least], key=lambda t: float(t.loss.sum()))


def white_loss(problem: Problem, noise: Noise) -> FloatArray:
    """Held-out squared error of each block in the metric of the noise, shape (B,)."""
    grams = calibration_grams(problem, noise, counted=False)
    return held_out_loss(grams.inner, grams.calibration)


def _of_the_likeliest(judged: Sequence[Problem]) -> Noise:
    """Noise of the model with the largest likelihood in noise of its own.

    Rows alone are scaled so that all models leave alike. What differs between hangings is taken at
    the upper end of its uncertainty, so that there what a model leaves counts too.
    """

    def surprise(problem: Problem, noise: Noise) -> float:
        left = float(white_loss(problem, noise).sum()) if noise.settled else 0.0
        return noise.level + 0.5 * left

    laws = [problem.law for problem in judged]
    return min(zip(judged, laws, strict=True), key=lambda pair: surprise(*pair))[1]


def _family(
    subject: Subject, about: Sequence[Cause], contenders: Sequence[Cause]
) -> list[Signature]:
    """What causes and their look-alikes could do, each in every shape.

    Together they are richer than each: knees at every load make a curve of any form.
    """
    kin = [c.signature for c in contenders if any(said_alike(subject.table, a, c) for a in about)]
    kin += [a.signature for a in about]
    effects, where = {s.effect for s in kin}, {s.where for s in kin}
    return [s for s in subject.problem.signatures if s.effect in effects and s.where in where]


def without_its_edge(field: Field, best: Tried, rules: Rules, gain: float) -> list[Signature]:
    """Smooth curves in the place of a knee that surely explains no more than without its edge.

    The polynomials of the table follow no curve that ends below the lightest loads; what they miss
    there is no evidence of a knee.
    """
    subject = field.subject
    effect = subject.table[best.cause.signature.effect]
    if effect.other_form is None:
        return []
    apply, remove = effect.other_form
    soft = replace(effect, apply=apply, remove=remove)
    other = replace(subject, table={**subject.table, effect.name: soft})
    _, fitted, bare = fit(other, field.causes, field.model, best.cause)
    lost = white_loss(other.without_credit(bare, fitted), field.noise) - best.loss
    sure = sign_flip_mean(lost, field.signs) < rules.alpha_rival
    if sure and float(lost.sum()) > share_for_form(best, rules.other_form, rules) * gain:
        return []
    where = best.cause.signature.where
    curves = [s for s in subject.problem.signatures if s.effect in SMOOTH and s.where == where]
    return list({s.effect: s for s in curves}.values())
