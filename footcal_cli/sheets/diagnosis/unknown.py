"""What has no name: its sentence and its signature card."""

from __future__ import annotations

import numpy as np

from footcal_cli.core.diagnosis.detection import Detection
from footcal_cli.core.diagnosis.engine import leftover
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.report import Sheet, number
from footcal_cli.sheets.diagnosis.words import causes_words, words


def unknown(found: Investigation, _experiment: str) -> tuple[str, list[str]]:
    """Something without a name."""
    sentence = (
        f"Something is missing and no library effect explains it. Signature: {depends_on(found)}, "
        f"in {most_touched(found)}."
    )
    details = [f"Considered and refused: {text}." for r in found.rounds for text in
               r.search.refused]  # fmt: skip
    if found.found:
        details.insert(0, f"Nearest: {causes_words(found)}, but too much is left beside it.")
    return sentence, details


def depends_on(found: Investigation) -> str:
    """What the leftover depends on, as a verb phrase."""
    detection = found.rounds[-1].before
    if detection.line_p < 0.01:
        name, frequency = detection.line
        return f"is a line at {number(frequency, 3)} Hz in {name}"
    if detection.between_p < 0.01:
        return f"moves with {detection.driver} from block to block"
    if detection.groups:
        best = int(np.argmin(detection.group_p))
        return f"depends on {detection.groups[best]}"
    return "repeats from block to block"


def most_touched(found: Investigation) -> str:
    """The output with the largest leftover."""
    problem = found.final
    energy = [
        float(np.mean(problem.residual[problem.output == o] ** 2))
        if np.any(problem.output == o) else 0.0
        for o in range(len(problem.outputs))
    ]  # fmt: skip
    return problem.outputs[int(np.argmax(energy))]


def card_sheets(found: Investigation) -> tuple[Sheet, ...]:
    """The signature card of what has no name."""
    detection = found.rounds[-1].before
    if not leftover(detection, found.rounds[-1].rules):
        return ()
    order = np.argsort(detection.group_p)[:3]
    rows = [
        ("output most touched", most_touched(found)),
        ("depends on", ", ".join(_group_words(detection, int(i)) for i in order) or "–"),
        ("line", f"{number(detection.line[1], 3)} Hz in {detection.line[0]}, "
                 f"p = {number(detection.line_p, 2)}" if detection.line[0] else "–"),
        ("between blocks", f"{detection.driver or 'no driver'}, p = "
                           f"{number(detection.between_p, 2)}"),
        ("share any function explains", f"{100 * detection.ceiling:.1f} %"),
        ("blocks in which it repeats",
         f"{int(np.sum(detection.flexible_gain > 0))} of {detection.flexible_gain.size}"),
        ("nearest library effects", ", ".join(
            f"{words(r.signature.effect)} ({r.signature.where})"
            for r in found.rounds[-1].effects[:3]) or "–"),
    ]  # fmt: skip
    return (Sheet("Signature card of what has no name", ("what", "value"), rows),)


def _group_words(detection: Detection, group: int) -> str:
    return f"{detection.groups[group]} (p = {number(float(detection.group_p[group]), 2)})"
