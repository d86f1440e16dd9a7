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
    moved_gain,
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
    if found.verdict is Verdict.BAD_DATA:
        # what is fitted to wrong readings shows nothing; the largest error does
        return (_jump(found) if found.once else _driver(found),)
    return (
        *((_moved_gain(found),) if found.gains_moved else ()),
        # a jump repeats with no signal, nor from block to block
        *((_jump(found),) if found.once else (_driver(found), _line_up(found, seed))),
        *_held_out(found),
        Picture(
            "isolability",
            lambda: isolability.plot_isolability(found, table, menu),
            isolability.CAPTION if menu is None or menu.best is None else isolability.AFTER_CAPTION,
            title="Which effects look alike",
            result=lambda: isolability.alike(found),
        ),
        *((_movement(moved),) if moved and found.found else ()),
        Picture(
            "null_gallery",
            lambda: null.plot_null(found),
            null.caption(found),
            title="Largest statistic of the data and by chance",
            result=lambda: null.in_words(found),
        ),
    )


def _driver(found: Investigation) -> Picture:
    named = bool(found.found)
    return Picture(
        "residual_against_driver",
        lambda: residuals.plot_driver(found),
        residuals.caption(named=named),
        title="Residual before and after the identified effect"
        if named
        else "Residual against the signal that predicts it best",
        result=lambda: residuals.in_words(found),
    )


def _jump(found: Investigation) -> Picture:
    return Picture(
        "jump",
        lambda: jump.plot_jump(found),
        jump.caption(found),
        title=jump.title(found),
        result=lambda: jump.in_words(found),
    )


def _moved_gain(found: Investigation) -> Picture:
    return Picture(
        "gain_against_calibration",
        lambda: moved_gain.plot_moved_gain(found.gains_moved),
        moved_gain.CAPTION,
        title="Gain of each cell against its calibration",
        result=lambda: moved_gain.in_words(found.gains_moved),
    )


def _line_up(found: Investigation, seed: int) -> Picture:
    return Picture(
        "line_up",
        lambda: line_up.plot_line_up(found, seed),
        line_up.LINE_UP_CAPTION,
        title="The data among nineteen random panels",
        result=lambda: f"The data are in panel {line_up.place_of_data(seed)}.",
    )


def _held_out(found: Investigation) -> tuple[Picture, ...]:
    """How well blocks are predicted that were left out of the fit."""
    return (
        Picture(
            "gain_per_block",
            lambda: gains.plot_gains(found),
            "Each block was left out of the fit that predicts it.",
            title="Error of each held-out block" + (" before and after" if found.found else ""),
            result=lambda: gains.in_words(found),
        ),
        Picture(
            "ladder",
            lambda: ladder.plot_ladder(found),
            ladder.caption(several=len(found.found) > 1),
            title="Held-out error of each model",
            result=lambda: ladder.in_words(found),
        ),
    )


def _movement(moved: tuple[Movement, ...]) -> Picture:
    return Picture(
        "movement",
        lambda: movement.plot_movement(moved),
        movement.MOVEMENT_CAPTION,
        title="Change of each calibration parameter",
        result=lambda: movement.in_words(moved),
    )
