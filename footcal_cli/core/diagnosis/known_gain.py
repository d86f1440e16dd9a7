"""A wrong mass in a walk: the gain that all cells share held to what was known before.

A walk whose cells were calibrated on the bench leaves that gain free, for it knows no other force
than the robot's own weight. A wrong mass then shows in no residual, only in a gain far from the
known one; and so does a calibration of which all gains have changed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.bridge import Describe, problem_from
from footcal_cli.core.diagnosis.floor import is_large
from footcal_cli.core.diagnosis.investigation import Investigation, named
from footcal_cli.core.diagnosis.path import Path, beginning, grown
from footcal_cli.core.diagnosis.rules import Rules
from footcal_cli.core.diagnosis.standing import happened
from footcal_cli.core.diagnosis.subject import Advance, Subject
from footcal_cli.core.effects.contract import Effect, Trait
from footcal_cli.core.inference.problem import Signature
from footcal_cli.core.inference.tracking import COMMON_GAIN, Direction


def with_known_gain(
    found: Investigation,
    table: Mapping[str, Effect],
    describe: Describe,
    rules: Rules,
    seed: int,
    advance: Advance,
) -> Investigation:
    """`found`, or what scales all forces; the cells' own calibration is a rival of what does alike.

    Asked only where nothing explains a residual that is large against the known calibration, and
    answered where it is large no more. Single blocks confirm nothing here: each of them has its own
    share of the gain.

    Parameters
    ----------
    table
        Effects by name that scale all forces, alike (`Trait.ALL_ALIKE`) or nearly.
    found, describe, rules, seed, advance
        See `investigate`.
    """
    held = tuple(way for way in found.case.directions if way.kind != COMMON_GAIN)
    free = len(held) < len(found.case.directions)
    if found.verdict is not Verdict.UNKNOWN or not (free and table):
        return found
    if not is_large(found.case, found.problem):
        return found
    subject, path = along_fewer(found, held, table, table, describe, rules, seed, advance)
    case = subject.case
    if not path.causes or is_large(case, path.current):
        return found
    (cause,) = path.causes
    names = {s.effect for s in (cause.signature, *cause.rivals)}
    if not any(Trait.ALL_ALIKE in table[name].traits for name in names):
        return found  # what scales them nearly alike was among all the others before
    calibrated = Signature(case.experiment.calibration[0], "scale", "all cells", "")
    cause = replace(cause, rivals=(*cause.rivals, calibrated))
    return named(subject, happened(subject, replace(path, causes=(cause,)), Verdict.AMBIGUOUS))


def along_fewer(
    found: Investigation,
    directions: Sequence[Direction],
    asked: Mapping[str, Effect],
    table: Mapping[str, Effect],
    describe: Describe,
    rules: Rules,
    seed: int,
    advance: Advance,
) -> tuple[Subject, Path]:
    """A walk whose gains may differ along fewer directions, and the one cause that it then shows.

    Parameters
    ----------
    asked, table
        Effects that are looked for, and all that an answer may name.
    found, describe, rules, seed, advance
        See `investigate`.
    """
    case = replace(found.case, directions=tuple(directions))
    problem = problem_from(case, found.problem, asked.values(), describe)
    subject = Subject(case, problem, table, describe, advance)
    only = replace(rules, most_effects=1)
    return subject, grown(subject, beginning(problem, rules, seed), only, seed)
