"""One sentence per verdict, and the lines below it."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.diagnosis.answer import EffectStatus
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.report import number
from footcal_cli.sheets.diagnosis.unknown import depends_on
from footcal_cli.sheets.diagnosis.words import causes_words, could_not, gain_words, words


def none_found(found: Investigation, _experiment: str) -> tuple[str, list[str]]:
    """Nothing found: what would have shown and what could not have."""
    shown = [
        f"{words(r.signature.effect)} > {number(r.detectable, 2)} {r.signature.unit}".rstrip(" -")
        for r in found.rounds[0].effects
        if r.status is not EffectStatus.NOT_TESTABLE and np.isfinite(r.detectable)
    ]
    details = []
    if shown:
        details.append("This data would have shown (power 0.8): " + ", ".join(shown) + ".")
    missing = could_not(found)
    if missing:
        details.append(f"It could NOT have shown: {missing}.")
    details += [f"Set aside: {text}." for text in found.rounds[0].search.refused]
    details.append("Not found does not mean not there; the table says what was looked for.")
    return "No unmodelled effect found.", details


def named(found: Investigation, _experiment: str) -> tuple[str, list[str]]:
    """One name or several, and nothing else."""
    last = found.rounds[-1].before
    sentence = f"Cause: {causes_words(found)}. {gain_words(found)}. Nothing else left."
    return sentence, [
        f"Left: nothing found (p = {number(last.p, 2)}).",
        *detail_lines(found),
    ]


def detail_lines(found: Investigation) -> list[str]:
    """Place, p, agreement between blocks, stability of the choice."""
    lines = []
    for item in found.found:
        cause = item.cause
        if cause.places:
            places = ", ".join(dict.fromkeys(s.where for s in cause.places))
            lines.append(
                f"Where: {words(cause.signature.effect)} in {cause.signature.where} cannot be told "
                f"from {places}."
            )
        lines.append(
            f"{words(cause.signature.effect)}: p = {number(cause.p, 2)} family-wise, size differs "
            f"between blocks by I² = {100 * cause.heterogeneity:.0f} %."
        )
    if found.case.one_recording:
        lines.append(
            "Repeatability between recordings is unknown: all this holds for this recording only."
        )
    if len(found.rounds) > 1 and found.stable < 1.0:
        lines.append(
            f"Leaving out single blocks keeps the first choice in {100 * found.stable:.0f} % of "
            "the cases."
        )
    return lines


def ambiguous(found: Investigation, experiment: str) -> tuple[str, list[str]]:
    """A set of rivals."""
    groups = [
        ", ".join(words(name) for name in dict.fromkeys(
            [f.cause.signature.effect, *(r.effect for r in f.cause.rivals)]
        ))
        for f in found.found if f.cause.rivals
    ]  # fmt: skip
    certain = [f for f in found.found if not f.cause.rivals]
    sentence = "One of {" + "}, and one of {".join(groups) + "}"
    if certain:
        sentence += " beside " + ", ".join(words(f.cause.signature.effect) for f in certain)
    sentence += ": these data cannot tell them apart."
    return sentence, [
        f"Run: {experiment}.",
        f"As {causes_words(found)}.",
        f"{gain_words(found)}.",
        *detail_lines(found),
    ]


def partly_named(found: Investigation, _experiment: str) -> tuple[str, list[str]]:
    """A name that explains a part."""
    last = found.rounds[-1].before
    first = found.rounds[0].before
    share = 1.0 - last.ceiling / max(first.ceiling, 1e-9) if first.ceiling > 0 else 1.0
    sentence = (
        f"{causes_words(found)} explains {100 * np.clip(share, 0, 1):.0f} % of what can be "
        f"explained; the rest {depends_on(found)} and has no name in the library."
    )
    return sentence, [f"{gain_words(found)}.", *detail_lines(found)]


def underpowered(found: Investigation, _experiment: str) -> tuple[str, list[str]]:
    """Too few blocks."""
    blocks = found.problem.blocks
    rules = found.rounds[0].rules
    more = max(rules.fewest_blocks - blocks, 1)
    return (
        f"{blocks} blocks cannot reach alpha = {rules.alpha_name:g} (smallest possible p is "
        f"{number(found.rounds[0].smallest_p, 2)}). Record at least {more} more.",
        ["Blocks are recordings, sessions or remounts, alike in content; more samples in the same "
         "block do not help."],
    )  # fmt: skip
