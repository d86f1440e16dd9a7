"""One sentence per verdict, and the lines below it: plain words first, numbers with units."""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil, log2

import numpy as np

from footcal_cli.core.diagnosis.answer import EffectStatus
from footcal_cli.core.diagnosis.detection import Detection
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.refusal import Why
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.plots.words import output_words, words
from footcal_cli.report import number, plural
from footcal_cli.sheets.diagnosis.refused import refused_lines
from footcal_cli.sheets.diagnosis.rivals import against_rivals, next_best
from footcal_cli.sheets.diagnosis.unknown import depends_on
from footcal_cli.sheets.diagnosis.words import (
    cannot_lines,
    cause_words,
    causes_words,
    gain_words,
    handy,
    handy_unit,
    remedy_of,
    shape_words,
    size_words,
    something_matters,
    subject_words,
    together,
    where_of,
)


def none_found(found: Investigation, untested: Mapping[str, str]) -> tuple[str, list[str]]:
    """Nothing found: what would have shown and what could not have."""
    small, surest = _repeats(found), _surest(found)
    details = [text for text in (small, surest) if text is not None]
    if found.nearest:
        nearest = "; ".join(cause_words(item, found.case.written) for item in found.nearest)
        details.append(
            f"Nearest in the table: {nearest}. It is not reported: it does not predict blocks "
            "that were left out of the fit, or is not chosen without them."
        )
    details.append(
        "Not found does not mean absent: the column 'found from' says how large each effect must "
        "be for these data to show it (4 times in 5)."
    )
    details += refused_lines(found.rounds[0].search.refused)
    details += _scope_lines(found)
    details += cannot_lines(found, untested)
    if nothing_testable(found):
        return "Nothing was found because nothing could be looked for.", details
    if small is not None:
        return "Nothing that matters: no effect of the table, and what repeats is small.", details
    last = found.rounds[-1]
    if surest is not None:
        return "Nothing that matters: what the table explains of the residual is small.", details
    if last.before.p < last.rules.alpha_unknown:
        return (
            "Nothing that matters: the residual is more than noise "
            f"(p = {number(last.before.p, 2)}), but small and like no effect of the table.",
            details,
        )
    if found.nearest:
        return "Nothing that matters: no effect of the table is sure enough for a name.", details
    return "No unmodelled effect found: the residual looks like noise.", details


def _surest(found: Investigation) -> str | None:
    """The effect that is surely there and surely too small to matter; None without one."""
    last = found.rounds[-1]
    impossible = {r.signature.cause for r in last.search.refused if r.why is Why.IMPOSSIBLE}
    rows = [
        row for row in last.effects
        if row.status is EffectStatus.ABSENT and row.p < last.rules.alpha_name
        and row.size.low * row.size.high > 0 and row.signature.cause not in impossible
    ]  # fmt: skip
    if not rows:
        return None
    row = min(rows, key=lambda row: row.p)
    factor, unit = handy_unit(row.size.value, row.signature.unit)
    needed = f"{number(factor * row.smallest, 2)} {unit}".rstrip()
    return (
        "Surest of the table, and too small to matter: "
        f"{subject_words(row.signature, found.case.written)}, "
        f"{handy(row.size, row.signature.unit)} (from {needed} on it would matter; "
        f"p = {number(row.p, 2)})."
    )


def _repeats(found: Investigation) -> str | None:
    """How large that is which repeats and has no name; None where nothing surely does."""
    last = found.rounds[-1]
    parts = [
        f"{number(item.rms, 2)} {item.unit} in the {output_words(item.output)} "
        f"(from {number(item.smallest, 2)} {item.unit} on it would matter)"
        for item in found.nameless
        if item.rms > 0.0
    ]
    if last.before.p >= last.rules.alpha_unknown or not parts:
        return None
    return f"Without a name, but the same from block to block (RMS): {together(parts)}."


def named(found: Investigation, untested: Mapping[str, str]) -> tuple[str, list[str]]:
    """One name or several, and nothing else."""
    lead = "Cause" if something_matters(found) else "Nothing that matters"
    small = _repeats(found)
    rest = "No other effect passes the tests"
    if small is not None:
        large = any(item.matters for item in found.nameless)
        rest = "What else repeats " + ("has no name" if large else "is too small to matter")
    sentence = f"{lead}: {causes_words(found)}. {gain_words(found)}. {rest}."
    last = found.rounds[-1].before
    other = next_best(found)
    lines = [] if other is None else [other]
    lines += _detail_lines(found)
    lines.append(small or _nothing_more(last, found.rounds[-1].rules))
    return sentence, [*lines, *cannot_lines(found, untested)]


def _nothing_more(last: Detection, rules: Rules) -> str:
    """How surely the residual with the names in the model is noise."""
    percent = 100 * last.ceiling
    share = "less than 0.1" if percent < 0.05 else f"{percent:.1f}"
    like = "looks like noise" if last.p >= rules.alpha_unknown else "is more than noise, but small"
    return (
        f"With this in the model the residual {like} (p = {number(last.p, 2)}); any "
        f"function of the recorded signals would explain {share} % more."
    )


def remedies(found: Investigation) -> list[str]:
    """What to do about each named cause, once."""
    texts = dict.fromkeys(remedy_of(found, item) for item in found.found)
    return [f"{text[0].upper()}{text[1:]}." for text in texts if text]


def ambiguous(found: Investigation, untested: Mapping[str, str]) -> tuple[str, list[str]]:
    """Sets of rivals."""
    groups = [
        together(
            (words(n) for n in [f.cause.signature.effect, *(r.effect for r in f.cause.rivals)]),
            "or",
        )
        for f in found.found
        if f.cause.rivals
    ]
    certain = [f for f in found.found if not f.cause.rivals]
    sentence = f"Either {', and either '.join(groups)}: these data cannot distinguish them"
    if not something_matters(found):
        sentence = f"Nothing that matters: e{sentence[1:].replace(':', ';')}"
    if certain:
        sure = together(words(f.cause.signature.effect) for f in certain)
        sentence += f" (in addition to {sure}, which is certain)"
    lines = [
        f"Were it {subject_words(f.cause.signature, found.case.written)}: {size_words(f)}."
        for f in found.found
        if f.cause.rivals
    ]
    lines += [*_odds_lines(found), *against_rivals(found)]
    return f"{sentence}.", [
        *lines,
        f"{gain_words(found)}.",
        *_detail_lines(found),
        *cannot_lines(found, untested),
    ]


def _odds_lines(found: Investigation) -> list[str]:
    """How probable each effect of a set of rivals is."""
    lines = []
    for shares in (f.cause.probability for f in found.found if f.cause.odds):
        likeliest = sorted(shares, key=shares.__getitem__, reverse=True)
        said = ", ".join(f"{words(name)} {_chance(shares[name])}" for name in likeliest)
        lines.append(
            f"By blocks that no fit had seen, with all of them equally likely beforehand: {said}."
        )
    return lines


def _chance(p: float) -> str:
    """A probability in whole per cent; no certainty that the data do not have."""
    return "less than 1 %" if p < 0.01 else f"{min(100 * p, 99.0):.0f} %"


def partly_named(found: Investigation, untested: Mapping[str, str]) -> tuple[str, list[str]]:
    """A name that explains a part."""
    last = found.rounds[-1].before
    first = found.rounds[0].before
    share = 1.0 - last.ceiling / max(first.ceiling, 1e-9) if first.ceiling > 0 else 1.0
    explains = f"explains {100 * np.clip(share, 0, 1):.0f} % of what can be explained; the rest"
    if found.once:  # a tracked calibration follows what happened once, but for its beginning
        explains = "this happened once; something else"
    sentence = f"{causes_words(found)}: {explains} {depends_on(found)} and has no name."
    return sentence[0].upper() + sentence[1:], [
        f"{gain_words(found)}.",
        *_detail_lines(found),
        *cannot_lines(found, untested),
    ]


def nothing_testable(found: Investigation) -> bool:
    """Whether these data could show no effect of the table at any size."""
    return all(row.status is EffectStatus.NOT_TESTABLE for row in found.rounds[0].effects)


def most_informative(found: Investigation) -> float:
    """Blocks that are informative of the effect that most of them show; 0 where none is tried."""
    return max((row.informative for row in found.rounds[0].effects), default=0.0)


def underpowered(found: Investigation, untested: Mapping[str, str]) -> tuple[str, list[str]]:
    """Too few blocks, or too few that show anything."""
    blocks = found.problem.blocks
    rules = found.rounds[0].rules
    if found.rounds[0].smallest_p <= rules.alpha_name and nothing_testable(found):
        needed = ceil(1.0 - log2(rules.alpha_name))  # p of equal signs is 2 / 2ⁿ
        most = most_informative(found)
        if most >= needed:
            return (
                f"Too little moves to identify a cause: {plural(blocks, 'block')} are enough, but "
                "each effect is loaded in too few of them, or its size stays less sure than what "
                "matters. Record more, and load every sensor more differently.",
                cannot_lines(found, untested),
            )  # fmt: skip
        return (
            f"Too short to identify a cause: of {plural(blocks, 'block')}, "
            f"{number(most, 2)} inform of any effect and {needed} are needed. "
            "Record for longer.",
            cannot_lines(found, untested),
        )  # fmt: skip
    more = max(rules.fewest_blocks - blocks, 1)
    return (
        f"Too few blocks to identify a cause: {plural(blocks, 'block')} can show "
        f"p = {number(found.rounds[0].smallest_p, 2)} at best, {rules.alpha_name:g} is needed. "
        f"Record at least {more} more.",
        ["Blocks are recordings, sessions or remounts, alike in content; more samples in the same "
         "block do not help."],
    )  # fmt: skip


def _detail_lines(found: Investigation) -> list[str]:
    """Place, p, agreement between blocks, stability of the choice."""
    lines = []
    for item in found.found:
        cause = item.cause
        name = words(cause.signature.effect)
        shape = shape_words(item)
        if shape:
            lines.append(f"Its shape: {shape}.")
        if cause.places:
            places = together(map(where_of, (cause.signature, *cause.places)), "or")
            lines.append(f"Where it sits is open: {places}.")
        agree = "; its size is the same in all blocks"
        if cause.heterogeneity > 0.3:
            share = 100 * cause.heterogeneity
            agree = f"; {share:.0f} % of the scatter of its size between blocks is more than noise"
        lines.append(
            f"{name[0].upper()}{name[1:]} by chance: p = {number(cause.p, 2)}, corrected for all "
            f"effects that were looked for{'' if found.once else agree}."
        )
    if len(found.rounds) > 1 and found.stable < 1.0:
        lines.append(
            f"Leaving out single blocks keeps the choice in {100 * found.stable:.0f} % of cases."
        )
    return lines + _scope_lines(found)


def _scope_lines(found: Investigation) -> list[str]:
    if not found.case.one_recording:
        return []
    return ["All from one recording: how well it repeats is unknown, and this holds for it only."]
