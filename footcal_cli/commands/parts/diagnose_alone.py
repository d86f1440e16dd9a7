"""What a fit of each cell by itself finds in weights that the diagnosis calls clean.

`offline-fit` judges every cell by its own rows; a diagnosis asks for evidence from many blocks.
What the one command surely finds the other must not deny.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from footcal_cli.commands.parts.diagnose_cases import CaseRead
    from footcal_cli.core.bench.study import ChannelStudy
    from footcal_cli.core.diagnosis.investigation import Investigation
    from footcal_cli.sheets.diagnosis.contract import Answer

_LEVEL, _WORTH = 0.001, 0.9


def found_alone(read: CaseRead, found: Investigation) -> tuple[str, ...]:
    """A sentence for every cell that needs more than a scale and a bias where none was named."""
    from footcal_cli.core.bench.record import BenchRecord
    from footcal_cli.core.bench.study import study_rows
    from footcal_cli.core.diagnosis.answer import Verdict
    from footcal_cli.sheets.ladder import study_sentence

    case = read.case
    rows_of_cells = case.experiment.name == "weights" and not case.one_recording
    if found.verdict is not Verdict.NONE or not rows_of_cells or len(case.chain.links) > 1:
        return ()
    sentences = []
    for log in case.logs:
        # of weights only what needs stamps is untested
        record = BenchRecord(
            log.channels[0], log.known["load_n"][:, 0], log.readings[:, 0], log.time_s, log.block,
            log.known.get("temperature_degc"), timed=not read.untested,
        )  # fmt: skip
        study = study_rows(record)
        sentence = study_sentence(study)
        if sentence is not None and _surely(study, len(case.logs)):
            sentences.append(sentence)
    return tuple(sentences)


def _surely(study: ChannelStudy, cells: int) -> bool:
    """Whether a cell's own model is beyond chance among all cells, and worth a tenth of its error.

    Of eight straight cells one in twelve needs more at the level of `offline-fit`.
    """
    if study.ladder is None:
        return False
    climbed = [row for row in study.ladder.rows if row.climbed and row.model != "affine"]
    before, after = study.ladder.rows[0].held_out_rmse_n, study.ladder.held_out.rmse
    sure = any(row.p_value < _LEVEL / cells for row in climbed)
    return sure and after < _WORTH * before


def undecided(answer: Answer, found: Investigation, sentences: tuple[str, ...]) -> Answer:
    """The answer where single cells need more than the diagnosis can name."""
    from dataclasses import replace

    from footcal_cli.records.results import VerdictRecord

    cells = len(found.case.logs)
    verdict = VerdictRecord(
        level="warning",
        sentence=(
            f"{len(sentences)} of {cells} cells need more than a scale and a bias, but too few "
            "blocks show it to name the cause."
        ),
        details=(
            *sentences,
            "offline-fit finds the same in these rows, and its calibration holds it. Record more "
            "sessions of these cells to have it named.",
        ),
    )
    return replace(answer, verdict=verdict)
