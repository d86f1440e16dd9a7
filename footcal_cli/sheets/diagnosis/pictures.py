"""The figures of a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping

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
    drawn = [
        Picture(
            "residual_against_driver",
            lambda: residuals.plot_driver(found),
            residuals.DRIVER_CAPTION,
            title="Residual before and after the identified effect",
            result=lambda: residuals.in_words(found),
        ),
        Picture(
            "line_up",
            lambda: line_up.plot_line_up(found, seed),
            line_up.LINE_UP_CAPTION,
            title="The data among nineteen random panels",
            result=lambda: f"The data stand in panel {line_up.place_of_data(seed)}.",
        ),
        Picture(
            "gain_per_block",
            lambda: gains.plot_gains(found),
            gains.GAINS_CAPTION,
            title="Error of each held-out block before and after",
            result=lambda: gains.in_words(found),
        ),
        Picture(
            "ladder",
            lambda: ladder.plot_ladder(found),
            ladder.LADDER_CAPTION,
            title="Held-out error of each model",
            result=lambda: gains.in_words(found),
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
            null.NULL_CAPTION,
            title="Largest statistic of the data and by chance",
            result=lambda: null.in_words(found),
        )
    )
    if found.once:
        # nothing that repeats with a signal, nor from block to block
        once = Picture(
            "jump",
            lambda: jump.plot_jump(found),
            jump.JUMP_CAPTION,
            title="The channel in the air, swing by swing",
            result=lambda: jump.in_words(found),
        )
        drawn[:2] = [once]
    return tuple(drawn)
