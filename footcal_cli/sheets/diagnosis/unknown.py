"""What has no name: its sentence and its signature card."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.detection import Detection
from footcal_cli.core.diagnosis.investigation import Found, Investigation
from footcal_cli.core.diagnosis.leftovers import Leftover, leftover_of, nameless
from footcal_cli.core.diagnosis.menu import Menu
from footcal_cli.core.inference.lines import Line
from footcal_cli.plots.words import output_words, words
from footcal_cli.report import Sheet, number
from footcal_cli.sheets.diagnosis.experiment import sharpening
from footcal_cli.sheets.diagnosis.refused import refused_lines
from footcal_cli.sheets.diagnosis.words import cannot_lines, cause_words, place_words, together

_CERTAIN = 0.01  # a test's p from which it is said in the first sentence


def unknown(found: Investigation, untested: Mapping[str, str]) -> tuple[str, list[str]]:
    """Something without a name."""
    sentence = (
        f"Something is missing that no effect of the table explains. It {depends_on(found)}"
        f"{_where(found)}."
    )
    if found.odd is not None and nameless(found)[1].before.p >= _CERTAIN:
        sentence = f"Something happened once: {found.odd.finding.sentence}."
    details = []
    if found.nearest:
        nearest = "; ".join(
            f"{cause_words(item, found.case.written)}{_or_rivals(item)}" for item in found.nearest
        )
        details.append(f"Nearest: {nearest}, but the residual is still too large.")
    details += refused_lines([item for r in found.rounds for item in r.search.refused])
    return sentence, [*details, *cannot_lines(found, untested)]


def _or_rivals(item: Found) -> str:
    """What else it may be as far as these data tell."""
    others = dict.fromkeys(words(rival.effect) for rival in item.cause.rivals)
    return f" (or {' or '.join(others)}, which look the same here)" if others else ""


def depends_on(found: Investigation) -> str:
    """What the leftover depends on, as a verb phrase."""
    detection = nameless(found)[1].before
    if _is_a_line(detection):
        return f"is a line at {line_words(detection.line)}"
    # what repeats over blocks with a signal is said before what differs between blocks
    if _signals_p(detection) >= _CERTAIN:
        if detection.between_p < _CERTAIN:
            return f"moves with {detection.driver} from block to block"
        if detection.spell_p < _CERTAIN:
            return "comes in spells, at no set time"
    left = leftover_of(found)
    return f"{left.direction} {left.driver}" if left.driver else "follows no recorded signal"


def _is_a_line(detection: Detection) -> bool:
    """Whether a line is more certain than any dependence on the signals."""
    return detection.line_p < _CERTAIN and detection.line_p <= _signals_p(detection)


def _signals_p(detection: Detection) -> float:
    """How surely the residual depends on a recorded signal."""
    return min(detection.bump_p, detection.flexible_p, detection.curve.p)


def _where(found: Investigation) -> str:
    """Output, cells and number of blocks; a line says itself where it is."""
    detection, left = nameless(found)[1].before, leftover_of(found)
    if _is_a_line(detection):
        return ""
    where = f", in the {output_words(left.output)}{_cells(left)}"
    apart = min(detection.between_p, detection.spell_p) < _CERTAIN <= _signals_p(detection)
    if apart or not left.blocks:
        return where
    return f"{where}, in {left.blocks} of {found.problem.blocks} blocks"


def line_words(line: Line) -> str:
    """Frequency, what may stand behind it, and where.

    Sampling folds what is faster than half the rate.
    """
    rate, found = line.rate_hz, line.frequency_hz
    folded = " or ".join(number(f, 3) for f in (rate - found, rate + found))
    return f"{number(found, 3)} Hz (or, folded, {folded} Hz …) in the {output_words(line.name)}"


def _cells(left: Leftover) -> str:
    if not left.channels or len(left.channels) > 3:
        return ""
    return f" of {together(left.channels)}"


def card_sheets(found: Investigation, menu: Menu | None) -> tuple[Sheet, ...]:
    """The signature card of what has no name."""
    detection = nameless(found)[1].before
    if found.verdict not in (Verdict.UNKNOWN, Verdict.NAMED_UNKNOWN):
        return ()
    left = leftover_of(found)
    order = np.argsort(detection.group_p, kind="stable")[:3]
    blocks = found.problem.blocks
    rows = [
        ("output most touched", output_words(left.output)),
        ("cells or axes", ", ".join(left.channels) or "all alike"),
        ("depends on", ", ".join(_group_words(detection, int(i)) for i in order) or "–"),
        ("direction", f"{left.direction} {left.driver}" if left.driver else "–"),
        ("strongest line", f"{line_words(detection.line)}, p = {number(detection.line_p, 2)}"
         if detection.line.name else "–"),
        ("between blocks", f"{detection.driver or 'no driver'}, p = "
                           f"{number(detection.between_p, 2)}"),
        ("comes in spells", f"p = {number(detection.spell_p, 2)}"),
        ("bends with", f"{detection.curve.name}, p = {number(detection.curve.p, 2)}"
         if detection.curve.name else "–"),
        ("begins", left.onset),
        ("share of the squared error that any function of the signals explains",
         f"{100 * detection.ceiling:.1f} %"),
        ("blocks in which it repeats", f"{left.blocks} of {blocks}"),
        ("nearest effects of the table (likeness, 1 being identical)", ", ".join(
            f"{words(name)}{place_words(where)} {cosine:.2f}" for name, where, cosine in
            left.nearest) or "–"),
        ("what would sharpen it", " – or ".join(sharpening(menu)) if menu and menu.prospects
         else "the same again, another day"),
    ]  # fmt: skip
    return (Sheet("Signature card of what has no name", ("what", "value"), rows),)


def _group_words(detection: Detection, group: int) -> str:
    return f"{detection.groups[group]} (p = {number(float(detection.group_p[group]), 2)})"
