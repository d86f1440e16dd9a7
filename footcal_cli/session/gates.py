"""Gates: what a result must meet to be accepted, judged in one place for every command."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from footcal_cli.core.quality import Finding, some_of
from footcal_cli.errors import nearest
from footcal_cli.recipe import CommandOptions, Gates
from footcal_cli.records.results import ParametersRecord, RmseRow, VerdictRecord
from footcal_cli.report import Sheet, number
from footcal_cli.report.outcome import Outcome

UNTRUSTED = frozenset(
    {
        "worse_than_before", "scale_off_nameplate", "dead_cell", "held_in_part", "turned_sign",
        "exchanged_channels", "duplicate_channel", "transducer_turned", "axis_turned",
        "negative_leg_weight", "forces_unexplained", "com_far", "loads_off_calibration",
        "leg_weight_off_recipe", "total_force_off_weight", "scale_out_of_reason",
        "stuck_channel", "leg_elsewhere", "scale_undetermined",
    }
)  # fmt: skip
"""Findings with which no calibration of these data means anything."""
WIRING = frozenset({"axis_turned", "transducer_turned", "exchanged_channels", "duplicate_channel"})
"""Those that say what to turn or to exchange; the others follow from them."""
DOUBTFUL = frozenset(
    {
        "legs_very_light", "negative_loads", "no_load", "calibration_of_another_robot",
        "unknown_sign_convention", "turned_sign", "time_goes_back", "body_left_interval",
    }
)  # fmt: skip
"""Warnings about units, signs, robots and their motion: what rests on them may be meaningless, so
not good."""
WORSE = 1.25
"""Ratio of an error after to that before from which a quantity got worse."""
SHARE = 0.1
"""And by this share of the largest error before among quantities of its unit."""
LEAST = {"N": 0.05, "m": 5e-4, "Nm": 5e-3}
"""And by so much at least: what is smaller does not matter."""


def trusted(outcome: Outcome) -> Outcome:
    """The outcome of a calibration with its doubts: not good and not usable where they weigh.

    What is wrong with the readings is the reason for all that the fit says, and stands first.
    """
    if outcome.parameters is None or outcome.diagnosis is not None:
        return outcome
    findings = (*outcome.findings, *_worse(outcome))
    doubts = [f for f in findings if f.code in UNTRUSTED and f.severity == "alarm"]
    verdict = outcome.verdict
    if doubts or (not outcome.usable and verdict.level == "good"):
        verdict = verdict.model_copy(update={"level": "bad"})
    wrong = [f for f in doubts if f in outcome.findings]
    if wrong:
        why = min(wrong, key=lambda f: f.code not in WIRING)
        first = {
            "sentence": f"{why.where}: {why.sentence.rstrip('.')}.",
            "actions": (f"{why.remedy[:1].upper()}{why.remedy[1:]}.",),
            "details": (verdict.sentence, *verdict.details),
        }
        verdict = verdict.model_copy(update=first)
    return replace(
        outcome, findings=findings, verdict=verdict, usable=outcome.usable and not doubts
    )


def _worse(outcome: Outcome) -> Iterator[Finding]:
    """Quantities that the calibration left worse than before, whatever the others gained."""
    rows = outcome.rmse.rows if outcome.rmse is not None else ()
    before = {_key(row): row for row in rows if row.stage == "before"}
    largest = {
        unit: max(row.rmse for row in before.values() if row.unit == unit)
        for unit in {row.unit for row in before.values()}
    }
    known = {row.reference for row in before.values()} - {"baseline"}
    judged = {outcome.reference} & known or known
    for row in rows:
        was = before.get(_key(row))
        if row.stage != outcome.stage or was is None:
            continue
        # another calibration is something to compare with, not what is true
        if row.reference not in judged:
            continue
        gained = row.rmse - was.rmse
        unsure = outcome.reference_sd.get(row.quantity, 0.0)
        floor = max(LEAST.get(row.unit, 0.0), SHARE * largest[row.unit], unsure)
        if row.rmse > WORSE * was.rmse and gained > floor:
            yield Finding(
                "worse_than_before", "alarm", row.quantity,
                f"the calibration made it worse: RMSE {was.rmse:.3g} → "
                f"{row.rmse:.3g} {row.unit} against {row.reference} "
                f"({row.split.replace('_', ' ')})",
                "do not use it; check the recipe against the log (footcal check), then "
                "run footcal diagnose",
            )  # fmt: skip


def _key(row: RmseRow) -> tuple[str, str, str]:
    return row.quantity, row.reference, row.split


LARGEST_CHANGE_SD = 5.0
"""Change against a reference calibration that is allowed where the recipe names no limit."""
_SHOWN = {"m": (1e3, "mm"), "rad": (180.0 / np.pi, "°")}
_MOST_NAMED = 8


@dataclass(frozen=True)
class Gate:
    """One limit and how it was met.

    Parameters
    ----------
    name, found, limit
        What was judged, in words.
    met
        Whether the result may pass.
    """

    name: str
    found: str
    limit: str
    met: bool

    @property
    def sentence(self) -> str:
        """The gate in one line."""
        return f"{self.name} {self.found}; allowed: {self.limit}"


def gated(
    outcome: Outcome,
    options: CommandOptions,
    shared: Mapping[str, Any],
    reference: ParametersRecord | None,
) -> Outcome:
    """Hold an outcome against its gates; what it missed stands in `gates_missed`.

    Parameters
    ----------
    options
        Of the command, with its gates.
    shared
        The recipe's own ``[gates]``: a command ignores patterns of quantities that it lacks.
    reference
        The calibration that parameters must not leave.
    """
    gates = options.gates
    optional = {name for key in ("max_rmse", "max_change") for name in shared.get(key, ())}
    found = [*_verdict(gates, outcome.verdict, outcome.diagnosis)]
    rows = [
        row
        for row in (outcome.rmse.rows if outcome.rmse is not None else ())
        if row.stage == outcome.stage and row.reference == (outcome.reference or row.reference)
    ]
    short = {name: limit for name, limit in options.limits.items() if limit is not None}
    for pattern, limit in {**gates.max_rmse, **short}.items():
        found += _rmse(pattern, limit, rows, optional=pattern in optional and pattern not in short)
    if outcome.parameters is not None:
        found += _changes(gates, optional, outcome.parameters, reference)
    missed = [gate.sentence for gate in found if not gate.met]
    if options.strict_findings:
        missed += _strict(outcome.findings)
    sheets = (*outcome.sheets, gate_sheet(found)) if found else outcome.sheets
    return replace(outcome, sheets=sheets, gates_missed=(*outcome.gates_missed, *missed))


def _strict(findings: Sequence[Finding]) -> list[str]:
    """The gate of ``--strict-findings``: warnings and alarms of the data, by code."""
    serious = sorted({f.code for f in findings if f.severity != "note"})
    return [f"strict findings: {', '.join(serious)}"] if serious else []


def gate_sheet(gates: Sequence[Gate]) -> Sheet:
    """All gates and how they were met."""
    return Sheet(
        "Gates",
        ("judged", "found", "allowed", "met"),
        [(g.name, g.found, g.limit, "yes" if g.met else "NO") for g in gates],
        note="What a gate rejects is written as parameters_rejected.json, and no command but "
        "diagnose starts from it.",
    )


def _verdict(gates: Gates, verdict: VerdictRecord, diagnosis: str | None) -> list[Gate]:
    found = []
    if gates.verdicts is not None:
        allowed = ", ".join(gates.verdicts)
        found.append(Gate("verdict", verdict.level, allowed, verdict.level in gates.verdicts))
    if gates.diagnoses is not None and diagnosis is not None:
        allowed = ", ".join(gates.diagnoses)
        found.append(Gate("diagnosis", diagnosis, allowed, diagnosis in gates.diagnoses))
    return found


def _rmse(pattern: str, limit: float, rows: Sequence[RmseRow], *, optional: bool) -> list[Gate]:
    """The worst of every quantity that a pattern names, on held-out data where there are some."""
    found = []
    names = dict.fromkeys(row.quantity for row in rows)
    for name in (n for n in names if fnmatchcase(n, pattern)):
        own = [row for row in rows if row.quantity == name]
        held_out = [row for row in own if row.split == "held_out"]
        worst = max(held_out or own, key=lambda row: row.rmse)
        factor, unit = _SHOWN.get(worst.unit, (1.0, worst.unit))
        where = "held out" if held_out else worst.split
        found.append(
            Gate(
                f"{name}: RMSE against {worst.reference} ({where})",
                f"{number(factor * worst.rmse)} {unit}",
                f"≤ {number(factor * limit)} {unit}",
                worst.rmse <= limit,
            )
        )
    return found or ([] if optional else [_nothing("max_rmse", pattern, list(names))])


def _changes(
    gates: Gates,
    optional: Collection[str],
    parameters: ParametersRecord,
    reference: ParametersRecord | None,
) -> list[Gate]:
    """Parameters that left the reference by more than they may."""
    limit_sd = gates.max_change_sd
    if reference is None:
        asked = [*gates.max_change, *(["max_change_sd"] if limit_sd is not None else [])]
        remedy = "a calibration to compare with: --reference, or reference in [gates]"
        return [Gate(f"change of {name}", "judges nothing here", remedy, False) for name in asked]
    if limit_sd is None and not gates.max_change:
        limit_sd = LARGEST_CHANGE_SD
    both = [name for name in parameters.parameters if name in reference.parameters]
    found = [
        gate
        for pattern, limit in gates.max_change.items()
        for gate in _in_units(pattern, limit, both, parameters, reference, pattern in optional)
    ]
    if limit_sd is not None:
        sizes = {name: _size_sd(name, parameters, reference) for name in both}
        sized = {name: size for name, size in sizes.items() if size is not None}
        if not sized:
            return [*found, _nothing("max_change_sd", "any parameter with a sd", both)]
        over = {n: size for n, size in sized.items() if not size <= limit_sd}
        named = over or {max(sized, key=sized.__getitem__): max(sized.values())}
        found += [
            Gate(
                f"{name}: change against the reference",
                f"{number(size, 3)} sd",
                f"≤ {number(limit_sd)} sd",
                name not in over,
            )
            for name, size in named.items()
        ]
    return found


def _in_units(
    pattern: str,
    limit: float,
    both: Sequence[str],
    parameters: ParametersRecord,
    reference: ParametersRecord,
    optional: bool,
) -> list[Gate]:
    """Changes beyond a limit; the largest one where none is."""
    names = [n for n in both if fnmatchcase(n, pattern) or fnmatchcase(n, f"*.{pattern}")]
    if not names:
        return [] if optional else [_nothing("max_change", pattern, both)]
    change = {n: parameters.parameters[n].value - reference.parameters[n].value for n in names}
    over = [n for n in names if not abs(change[n]) <= limit]
    named = over or [max(names, key=lambda n: abs(change[n]))]
    return [
        Gate(
            f"{n}: change against the reference",
            f"{number(change[n])} {parameters.parameters[n].unit}",
            f"within ± {number(limit)} {parameters.parameters[n].unit}",
            n not in over,
        )
        for n in named
    ]


def _size_sd(name: str, parameters: ParametersRecord, reference: ParametersRecord) -> float | None:
    """|change| over the sd of both calibrations together; None where neither has one."""
    new, old = parameters.parameters[name], reference.parameters[name]
    sd = float(np.hypot(new.sd or 0.0, old.sd or 0.0))
    return abs(new.value - old.value) / sd if sd > 0 else None


def _nothing(key: str, pattern: str, names: Sequence[str]) -> Gate:
    """A gate that judges nothing is not met: its name may be a slip of the pen."""
    known = f": {some_of(names, _MOST_NAMED)}" if names else ""
    return Gate(
        f"{key} '{pattern}'",
        f"judges nothing here{nearest(pattern, names)}",
        f"a name or pattern of what there is{known}",
        met=False,
    )


def merged(shared: Mapping[str, object], own: Mapping[str, object]) -> dict[str, object]:
    """Gates of a command on top of the recipe's: key by key, limits name by name."""
    result = dict(shared)
    for key, value in own.items():
        before = result.get(key)
        both = isinstance(before, Mapping) and isinstance(value, Mapping)
        result[key] = {**before, **value} if both else value  # type: ignore[dict-item]
    return result
