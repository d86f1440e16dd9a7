"""What became of the rivals of the log before: in words and as records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.suspects import Followed, Suspect, followed, survivors, suspects_of
from footcal_cli.core.effects.contract import Effect
from footcal_cli.plots.words import words
from footcal_cli.records.diagnosis import DiagnosisRecord, FollowedRecord, SuspectRecord
from footcal_cli.sheets.diagnosis.words import together


def suspect_records(found: Investigation, table: Mapping[str, Effect]) -> tuple[SuspectRecord, ...]:
    """The rivals of this log, for the one after it."""
    return tuple(
        SuspectRecord(effect=s.effect, owners=dict(s.owners), values=dict(s.values), sd=s.sd)
        for s in suspects_of(found, table)
    )


def after(
    found: Investigation, before: DiagnosisRecord | None, table: Mapping[str, Effect]
) -> tuple[Followed, ...]:
    """The rivals of the log before in this one."""
    if before is None or not before.suspects:
        return ()
    suspects = [Suspect(s.effect, s.owners, s.values, s.sd) for s in before.suspects]
    return followed(found, suspects, table)


def left_over(found: Investigation, became: Sequence[Followed]) -> tuple[str, ...]:
    """Rivals of the log before that are still possible."""
    causes = [item.cause for item in found.found]
    named = [c.signature.effect for c in causes] + [r.effect for c in causes for r in c.rivals]
    return survivors(found.verdict, named, became)


def followed_words(became: Sequence[Followed], left: Sequence[str]) -> str:
    """One sentence on the rivals of the log before."""
    asked = together(words(f.effect) for f in became)
    if not left:
        return f"Of {asked}, rivals in the log before, this one says nothing certain."
    gone = [
        f"{words(f.effect)} {f.share.value:.2f} [{f.share.low:.2f}, {f.share.high:.2f}]"
        for f in became
        if f.share is not None and f.effect not in left
    ]
    shares = f" Share that is here of what the other log asked for: {'; '.join(gone)}." * bool(gone)
    verb = "is" if len(left) == 1 else "are"
    return (
        f"Of {asked}, rivals in the log before, {together(words(n) for n in left)} {verb} left."
        f"{shares}"
    )


def followed_records(became: Sequence[Followed]) -> tuple[FollowedRecord, ...]:
    """The rivals of the log before, as they stand in ``diagnosis.json``."""
    return tuple(
        FollowedRecord(
            effect=f.effect,
            share=None if f.share is None else f.share.value,
            ci95=None if f.share is None else (f.share.low, f.share.high),
            says=f.says.value,
        )
        for f in became
    )
