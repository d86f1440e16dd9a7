"""Which experiment next, in words and as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.menu import Prospect, advice, prospects
from footcal_cli.core.effects.contract import Effect
from footcal_cli.report import Sheet, number
from footcal_cli.sheets.diagnosis.contract import Answer


def menu_of(found: Investigation, table: Mapping[str, Effect]) -> tuple[Prospect, ...]:
    """The menu judged for the first pair of rivals; empty where there is none."""
    for item in found.found:
        if not item.cause.rivals:
            continue
        rival = item.cause.rivals[0]
        if found.case.experiment.name not in ("weights", "placements"):
            return ()
        load = max(float(np.nanmax(np.abs(log.known["load_n"]))) for log in found.case.logs)
        problem = found.problem
        noise = float(np.median(problem.noise[problem.output == 0]))
        return prospects(item.cause.signature, rival, table, item.cause.size.value, noise, load)
    return ()


def next_experiment(
    found: Investigation, table: Mapping[str, Effect], menu: Sequence[Prospect]
) -> str:
    """What to run next: the best of the menu, else the table's advice."""
    if menu and menu[0].repeats < 10**6:
        best = menu[0]
        times = f", {best.repeats} times" if best.repeats > 1 else ""
        now = _cosine_now(found)
        return (
            f"{best.words}{times} (|cos| of the rivals {now:.4f} here, {best.cosine:.4f} then; "
            f"predicted separation {number(best.separation, 2)} noise sd)"
        )
    for item in found.found:
        if item.cause.rivals:
            names = [item.cause.signature.effect, *(r.effect for r in item.cause.rivals)]
            return advice([table[n] for n in dict.fromkeys(names) if n in table])
    if found.verdict is Verdict.UNDERPOWERED:
        return f"at least {max(10 - found.problem.blocks, 1)} more recordings of the same kind"
    return ""


def _cosine_now(found: Investigation) -> float:
    """|cos| of the first pair of rivals on these data."""
    cause = next(f.cause for f in found.found if f.cause.rivals)
    problem = found.problem
    index = {s: i for i, s in enumerate(problem.signatures)}
    pair = [index[s] for s in (cause.signature, cause.rivals[0]) if s in index]
    if len(pair) < 2:
        return 1.0
    from dataclasses import replace

    left = replace(
        problem, columns=problem.columns[:, pair], signatures=tuple(problem.signatures[i]
                                                                    for i in pair)
    ).left()  # fmt: skip
    norms = np.sqrt(np.sum(left**2, axis=0))
    return float(abs(left[:, 0] @ left[:, 1]) / max(norms[0] * norms[1], 1e-300))


def menu_sheets(answer: Answer) -> tuple[Sheet, ...]:
    """The menu of experiments, judged."""
    if not answer.menu:
        return ()
    rows = [
        (
            p.words, f"{p.cosine:.3f}", number(p.separation, 3),
            str(p.repeats) if p.repeats < 10**4 else "hopeless",
        )
        for p in answer.menu
    ]  # fmt: skip
    return (
        Sheet(
            "Which experiment would tell the rivals apart",
            ("experiment on one cell", "|cos| of the rivals", "separation (noise sd)",
             "runs for power 0.8"),
            rows,
            note="Predicted by simulating each experiment with the fitted size and this data's "
            "noise, calibration and rival refitted.",
        ),
    )  # fmt: skip
