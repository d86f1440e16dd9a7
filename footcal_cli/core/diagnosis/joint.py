"""Several experiments diagnosed together: which causes explain all of them, with shared sizes.

Each is diagnosed by itself first; `footcal_cli.core.diagnosis.joint_hypotheses` then narrows what
it leaves open by what the others say.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.joint_hypotheses import (
    SAYS_NOTHING,
    Hypotheses,
    JointSize,
    SingleFinding,
    candidates_of,
)
from footcal_cli.core.diagnosis.joint_sizes import SingleDiagnosis
from footcal_cli.core.effects.contract import Effect


@dataclass(frozen=True)
class JointDiagnosis:
    """The answer about several experiments.

    Parameters
    ----------
    verdict
        One word.
    causes
        Of the most probable combination.
    singles
        The experiments.
    open_in
        Experiments in which something is left that no name explains.
    """

    verdict: Verdict
    causes: tuple[JointSize, ...]
    singles: tuple[SingleDiagnosis, ...]
    open_in: tuple[str, ...]

    @property
    def agreed(self) -> bool:
        """Whether its causes are an answer; else they only came nearest to one."""
        return self.verdict in (Verdict.NAMED, Verdict.AMBIGUOUS, Verdict.NAMED_UNKNOWN)


def diagnose_together(
    singles: Sequence[SingleDiagnosis], table: Mapping[str, Effect]
) -> JointDiagnosis:
    """One answer from the diagnoses of several experiments.

    Parameters
    ----------
    singles
        Each with its own diagnosis.
    table
        Effects by name.
    """
    usable = [s for s in singles if s.found.verdict is not Verdict.BAD_DATA]
    findings = [
        SingleFinding(i, candidates_of(item, usable, table))
        for i, single in enumerate(usable)
        for item in single.findings
    ]
    causes = Hypotheses(usable, findings, table).answer() if findings else ()
    open_in = tuple(s.name for s in usable if s.found.verdict in SAYS_NOTHING)
    return JointDiagnosis(_verdict(usable, causes, open_in), causes, tuple(singles), open_in)


def _verdict(
    usable: Sequence[SingleDiagnosis], causes: Sequence[JointSize], open_in: Sequence[str]
) -> Verdict:
    own = [s.found.verdict for s in usable]
    if not own:
        return Verdict.BAD_DATA
    if any(c.excluded for c in causes):
        return Verdict.UNKNOWN
    if not causes:
        if open_in:
            return Verdict.UNKNOWN
        return Verdict.NONE if Verdict.NONE in own else Verdict.UNDERPOWERED
    several = any(len(c.rivals) > 1 for c in causes)
    if open_in:
        return Verdict.UNKNOWN if several else Verdict.NAMED_UNKNOWN
    return Verdict.AMBIGUOUS if several else Verdict.NAMED
