"""Which experiment next, in words, as a table and as a record."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.menu import Menu, Prospect, advice
from footcal_cli.core.effects.contract import Effect, Trait
from footcal_cli.plots.words import words
from footcal_cli.records.diagnosis import NextExperimentRecord
from footcal_cli.report import Sheet, number
from footcal_cli.sheets.diagnosis.words import together


def next_experiment(
    found: Investigation, table: Mapping[str, Effect], menu: Menu | None
) -> NextExperimentRecord | None:
    """What to run next: the best of the menu, else the table's advice; None where nothing is."""
    if found.verdict is Verdict.UNDERPOWERED:
        more = max(10 - found.problem.blocks, 1)
        kind = found.case.experiment.name
        return NextExperimentRecord(
            id="", kind=kind, words=f"at least {more} more recordings of the same kind",
            repeats=more,
        )  # fmt: skip
    if menu is not None and menu.best is not None:
        return experiment_record(menu)
    for item in found.found:
        if item.cause.rivals:
            names = [item.cause.signature.effect, *(r.effect for r in item.cause.rivals)]
            asked = [table[n] for n in dict.fromkeys(names) if n in table]
            moved = [effect for effect in asked if Trait.GAIN in effect.traits]
            said = advice(moved or asked)
            return NextExperimentRecord(id="", kind="", words=said) if said else None
    return None


def experiment_record(menu: Menu) -> NextExperimentRecord | None:
    """The best plan of a menu, with what it promises."""
    return None if menu.best is None else prospect_record(menu, menu.best)


def prospect_record(menu: Menu, prospect: Prospect) -> NextExperimentRecord:
    """One plan of a menu, with what it promises."""
    rivals = tuple(dict.fromkeys(r.signature.effect for r in menu.rivals))
    return NextExperimentRecord(
        id=prospect.plan.id,
        kind=prospect.plan.experiment.name,
        words=prospect.plan.words,
        between=rivals,
        cosine_now=None if menu.now is None else menu.now.cosine,
        cosine_after=prospect.cosine,
        separation_now=None if menu.now is None else menu.now.separation,
        separation=prospect.separation,
        repeats=prospect.repeats,
        minutes=prospect.minutes,
        without=tuple(r for r in rivals if r in prospect.plan.settles),
    )


def sharpening(menu: Menu) -> list[str]:
    """Two experiments, of different kinds where there are, that show most of the nearest names."""
    if not menu.prospects:
        return []
    first, *rest = sorted(menu.prospects, key=lambda p: p.minutes)
    other = [p for p in rest if p.plan.experiment is not first.plan.experiment]
    return [p.plan.words for p in (first, *(other or rest)[:1])]


def options_of(record: NextExperimentRecord) -> str:
    """The options of `diagnose` on its log: the kind, and what is out of the question then."""
    return record.kind + "".join(f" --without {name}" for name in record.without)


def experiment_words(record: NextExperimentRecord | None) -> str:
    """The experiment as a clause: what, how often, what for."""
    if record is None:
        return ""
    times = f", {record.repeats} times" if record.id and (record.repeats or 1) > 1 else ""
    if record.cosine_after is None:
        return record.words + times
    now = "" if record.cosine_now is None else f"{record.cosine_now:.3f} here, "
    minutes = f", about {record.minutes:.0f} min" if record.minutes else ""
    # without some of the rivals, or by more runs, they part whatever they look like
    parts = not record.without and record.cosine_after < (record.cosine_now or np.inf)
    likeness = (
        f"; likeness of the rivals, 1 being identical: {now}{record.cosine_after:.3f} then"
        if parts else ""
    )  # fmt: skip
    return f"{record.words}{times} (kind {options_of(record)}{minutes}{likeness})"


def menu_sheets(menu: Menu | None) -> tuple[Sheet, ...]:
    """The menu of experiments, judged."""
    if menu is None or not menu.prospects:
        return ()
    rows = [
        (
            p.plan.words, p.plan.experiment.name, f"{p.left:.1f}", f"{p.cosine:.3f}",
            number(p.separation, 3), str(p.repeats), f"{p.minutes:.0f}",
        )
        for p in menu.prospects
    ]  # fmt: skip
    names = together(words(r.signature.effect) for r in menu.rivals)
    now = ""
    if menu.now is not None:
        now = f" In the present data the nearest rival has a likeness of {menu.now.cosine:.3f}."
    return (
        Sheet(
            f"Which experiment would distinguish {names}",
            ("experiment", "kind", "rivals remaining", "likeness", "separation", "runs", "minutes"),
            rows,
            note="Every experiment is simulated with the fitted sizes and this data's noise, "
            "calibration and rival refitted. Rivals remaining: how many, besides the true one. "
            "Likeness: largest |cos| of two that it distinguishes, 0 where one is invisible. "
            "Separation: in noise sd of one run, a third of the prediction. Runs: for a power of "
            f"0.8.{now}",
            folded_after=8,
        ),
    )
