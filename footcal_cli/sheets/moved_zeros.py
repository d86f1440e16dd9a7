"""Sentences on channels of which only the zero moves from session to session.

Room: sheets; asked by ladder.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from footcal_cli.core.bench.moved_zeros import MovedZeros, moved_zeros
from footcal_cli.core.bench.study import ChannelStudy
from footcal_cli.records.results import VerdictRecord
from footcal_cli.report import number, plural
from footcal_cli.sheets.weights import inadequate

_MOST = 3
_MOST_ZEROS = 6
TAKE_ZEROS = (
    "Where the logs have none, take zeros as the cells are used: `zeros` in [data], of the robot "
    "in the air or the empty plate."
)


def zeros_alone(
    studies: Sequence[ChannelStudy], channels: Sequence[str], tolerance_n: float
) -> dict[str, MovedZeros]:
    """Of some channels those that a scale and a zero for each session describe, worst first."""
    found = {
        study.channel: moved
        for study in studies
        if study.channel in channels and (moved := moved_zeros(study.record)) is not None
    }
    left = {fit.channel for fit in inadequate([m.fit for m in found.values()], tolerance_n)}
    kept = [name for name in found if name not in left]
    return {name: found[name] for name in sorted(kept, key=lambda n: -found[n].span_n)}


def zero_sentences(moved: Mapping[str, MovedZeros]) -> list[str]:
    """The zeros of the channels that move most, and what is left within sessions."""
    texts = []
    for name, zeros in list(moved.items())[:_MOST]:
        values = [number(z, 2) for z in zeros.zero_n.tolist()[:_MOST_ZEROS]]
        said = ", ".join(values) + ", …" * (zeros.zero_n.size > _MOST_ZEROS)
        texts.append(
            f"{name}: zeros of its {plural(zeros.zero_n.size, 'session')} {said} N about their "
            f"mean; with them the largest error is {number(zeros.fit.worst_n, 2)} N"
        )
    more = len(moved) - _MOST
    return [*texts, *([f"{plural(more, 'more channel')} of which the zero moves."] * (more > 0))]


def zeros_verdict(
    moved: Mapping[str, MovedZeros], share: str, details: Sequence[str]
) -> VerdictRecord:
    """One scale describes each channel, and the zero of a `share` of them moves."""
    name, worst = next(iter(moved.items()))
    return VerdictRecord(
        level="warning",
        sentence=f"Scales hold, but the zero of {share} moves from session to session, by up to "
        f"{number(worst.span_n, 2)} N ({name}).",
        actions=(TAKE_ZEROS,),
        details=tuple(details),
    )
