"""The verdict of a diagnosis in words, and what to do next."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from footcal_cli.core.bench_rows import UNEVEN
from footcal_cli.core.diagnosis.answer import EffectStatus, Verdict
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.next_experiment import next_menu
from footcal_cli.core.effects.cells import NONLINEARITY
from footcal_cli.core.effects.contract import Effect
from footcal_cli.core.effects.memory_effects import CREEP, HYSTERESIS
from footcal_cli.core.quality import CAUSES, Finding, stopping
from footcal_cli.records.diagnosis import NextExperimentRecord
from footcal_cli.records.results import VerdictRecord
from footcal_cli.report import number
from footcal_cli.sheets.diagnosis.contract import Answer
from footcal_cli.sheets.diagnosis.experiment import experiment_words, next_experiment, sharpening
from footcal_cli.sheets.diagnosis.sentences import (
    ambiguous,
    named,
    none_found,
    partly_named,
    remedies,
    underpowered,
)
from footcal_cli.sheets.diagnosis.unknown import unknown
from footcal_cli.sheets.diagnosis.words import rival_groups

LADDER_AGAIN = (
    "a ladder of at least six weights up and down, two holds of five minutes, each cell alone, "
    "three times"
)


def stopped(found: Investigation, stop: Sequence[Finding]) -> Answer:
    """Bad data: say so, and what can be said all the same."""
    what = re.split(r":| \(", stop[0].sentence)[0]
    sentence = f"Not diagnosed, because readings are wrong: {stop[0].where}, {what}."
    actions = [f"First {stop[0].remedy}."] if stop[0].remedy else []
    details: list[str] = []
    rivals: tuple[tuple[str, ...], ...] = ()
    experiment = None
    if found.case.experiment.name == "weights":
        bent = _curvature(found)
        if bent:
            details += bent
            what = "nonlinearity from creep or the order of loading"
            repeats = "with four unrepeated points" if _unrepeated(found) else "here"
            details.append(f"These readings cannot distinguish {what} {repeats}.")
            rivals = (tuple(effect.name for effect in (NONLINEARITY, CREEP, HYSTERESIS)),)
        experiment = NextExperimentRecord(id="up_down", kind="weights", words=LADDER_AGAIN)
        actions.append(f"Run next: {LADDER_AGAIN}.")
    return Answer(
        VerdictRecord(
            level="bad", sentence=sentence, actions=tuple(actions), details=tuple(details)
        ),
        rivals,
        experiment,
    )


def _unrepeated(found: Investigation) -> bool:
    return all(np.unique(log.known["load_n"]).size == len(log) == 4 for log in found.case.logs)


def _curvature(found: Investigation) -> list[str]:
    """Whether scale and bias are inadequate, and whether all channels bend alike."""
    from footcal_cli.core.bench.regression import fit_affine, pooled_curvature

    fits = []
    for log in found.case.logs:
        load = log.known["load_n"].reshape(len(log), -1)[:, 0]
        known = np.isfinite(load)
        fits.append(fit_affine(log.channels[0], load[known], log.readings[known, 0]))
    worst = max(fits, key=lambda f: f.worst_n)
    largest = max(float(np.abs(f.load_n).max()) for f in fits)
    if worst.worst_n < 0.01 * largest:
        return []
    curvature = pooled_curvature(fits)
    lines = [
        f"Affine inadequate: errors up to {number(worst.worst_n, 2)} N ({worst.channel}) of "
        f"{number(largest, 3)} N."
    ]
    if curvature is not None:
        shape = "compressive" if curvature.mean > 0 else "expansive"
        lines.append(
            f"Shared {shape} curve: {curvature.same_sign} of {len(curvature.bows)} channels bend "
            f"the same way (mean bow {100 * abs(curvature.mean):.1f} % of the span, sign test p = "
            f"{number(curvature.sign_p, 2)} were the channels independent)."
        )
    return lines


_ASKS = (Verdict.AMBIGUOUS, Verdict.UNKNOWN, Verdict.NAMED_UNKNOWN)
"""Verdicts that an experiment would sharpen."""


def _small(sentence: str) -> str:
    """A sentence behind a colon."""
    return sentence[:1].lower() + sentence[1:]


def answer_of(
    found: Investigation,
    table: Mapping[str, Effect],
    findings: Sequence[Finding],
    untested: Mapping[str, str],
) -> Answer:
    """Turn an investigation into its sentence."""
    kind = found.verdict
    if kind is Verdict.BAD_DATA:
        return stopped(found, stopping(findings))
    menu = next_menu(found, table) if kind in _ASKS else None
    experiment = next_experiment(found, table, menu)
    speak = {
        Verdict.NONE: none_found,
        Verdict.NAMED: named,
        Verdict.AMBIGUOUS: ambiguous,
        Verdict.NAMED_UNKNOWN: partly_named,
        Verdict.UNKNOWN: unknown,
        Verdict.UNDERPOWERED: underpowered,
    }[kind]
    sentence, details = speak(found, untested)
    uneven = [f for f in findings if f.code == UNEVEN]
    if uneven and kind is Verdict.UNKNOWN:
        sentence = f"{uneven[0].where} is unlike the other cells: {uneven[0].sentence}."
    unnamed = kind in (Verdict.NONE, Verdict.UNDERPOWERED)
    sure = [f for f in findings if f.code in CAUSES] if unnamed else []
    if sure:
        said = "; ".join(f"{f.where}: {f.sentence}" for f in sure)
        sentence = f"Found before the search: {said}. Apart from that: {_small(sentence)}"
    actions = remedies(found) if kind in (Verdict.NAMED, Verdict.NAMED_UNKNOWN) else []
    tested = any(r.status is not EffectStatus.NOT_TESTABLE for r in found.rounds[0].effects)
    if experiment is not None and kind is Verdict.AMBIGUOUS:
        actions.append(f"Run next: {experiment_words(experiment)}.")
    elif menu is not None and menu.prospects:
        actions.append(f"Run next, to learn more: {' – or '.join(sharpening(menu))}.")
    return Answer(
        VerdictRecord(
            level="good" if kind is Verdict.NONE and tested and not sure else "warning",
            sentence=sentence,
            actions=tuple(actions),
            details=tuple(details),
        ),
        rival_groups(found),
        experiment,
        menu,
    )
