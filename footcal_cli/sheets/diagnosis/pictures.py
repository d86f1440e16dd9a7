"""The figures of a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping

from footcal_cli.core.diagnosis.answer import Verdict
from footcal_cli.core.diagnosis.investigation import Investigation
from footcal_cli.core.diagnosis.menu import Menu
from footcal_cli.core.diagnosis.movement import Movement
from footcal_cli.core.effects.contract import Effect
from footcal_cli.plots.diagnosis import (
    gains,
    isolability,
    jump,
    ladder,
    line_up,
    movement,
    null,
    residuals,
)
from footcal_cli.report import Picture


def pictures_of(
    found: Investigation,
    table: Mapping[str, Effect],
    moved: tuple[Movement, ...],
    menu: Menu | None,
    seed: int,
) -> tuple[Picture, ...]:
    """All figures of one investigation."""
    named = bool(found.found)
    drawn = [
        Picture(
            "residual_against_driver",
            lambda: residuals.plot_driver(found),
            residuals.caption(named=named),
            title="Residual before and after the identified effect"
            if named
            else "Residual against the signal that predicts it best",
            result=lambda: residuals.in_words(found),
        ),
        Picture(
            "line_up",
            lambda: line_up.plot_line_up(found, seed),
            line_up.LINE_UP_CAPTION,
            title="The data among nineteen random panels",
            result=lambda: f"The data are in panel {line_up.place_of_data(seed)}.",
        ),
        Picture(
            "gain_per_block",
            lambda: gains.plot_gains(found),
            "Each block was left out of the fit that predicts it.",
            title="Error of each held-out block" + (" before and after" if named else ""),
            result=lambda: gains.in_words(found),
        ),
        Picture(
            "ladder",
            lambda: ladder.plot_ladder(found),
            ladder.caption(several=len(found.found) > 1),
            title="Held-out error of each model",
            result=lambda: ladder.in_words(found),
        ),
        Picture(
            "isolability",
            lambda: isolability.plot_isolability(found, table, menu),
            isolability.CAPTION if menu is None or menu.best is None else isolability.AFTER_CAPTION,
            title="Which effects look alike",
            result=lambda: isolability.alike(found),
        ),
    ]
    if moved and found.found:
        drawn.append(
            Picture(
                "movement",
                lambda: movement.plot_movement(moved),
                movement.MOVEMENT_CAPTION,
                title="Change of each calibration parameter",
                result=lambda: movement.in_words(moved),
            )
        )
    drawn.append(
        Picture(
            "null_gallery",
            lambda: null.plot_null(found),
            null.caption(found),
            title="Largest statistic of the data and by chance",
            result=lambda: null.in_words(found),
        )
    )
    if found.once:
        # nothing that repeats with a signal, nor from block to block
        once = Picture(
            "jump",
            lambda: jump.plot_jump(found),
            jump.caption(found),
            title=jump.title(found),
            result=lambda: jump.in_words(found),
        )
        drawn[:2] = [once]
    # what is fitted to wrong readings shows nothing; the largest error does
    return tuple(drawn[:1] if found.verdict is Verdict.BAD_DATA else drawn)
