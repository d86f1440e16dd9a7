"""Intervals of a bench's channels under the noise that all of them show together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footcal_cli.core.bench.channel import ChannelFit, finish_channel
from footcal_cli.core.bench.record import BenchRecord, load_levels
from footcal_cli.core.bench.regressors import model_of
from footcal_cli.core.bench.study import ChannelStudy
from footcal_cli.core.inference.blocks import BlockFit
from footcal_cli.core.inference.shared_noise import (
    Common,
    Regression,
    common_law,
    fit_under,
    law_under,
)
from footcal_cli.core.parameters import FloatArray

_MOST_ROWS = 150
"""A longer record shows its own noise, and dense matrices of its rows cost too much."""


def with_common_noise(studies: Sequence[ChannelStudy]) -> tuple[ChannelStudy, ...]:
    """Studies whose models know the noise that the channels of a bench share.

    One channel of a few sessions hardly shows how far its zero differs between them, nor how long
    an error lasts; all of them together do.
    """
    short = [
        (study, study.ladder, _rows_of(study.record, study.ladder.chosen))
        for study in studies
        if study.ladder is not None and study.ladder.chosen.rows <= _MOST_ROWS
    ]
    if not short:
        return tuple(studies)
    common = common_law([rows for _, _, rows in short])
    better = {}
    for study, ladder, rows in short:
        if study.fit is not None or common.lasting:
            chosen = _refit(study.record, ladder.chosen, rows, common)
            better[study.channel] = replace(study, ladder=replace(ladder, chosen=chosen))
    return tuple(better.get(study.channel, study) for study in studies)


def _rows_of(record: BenchRecord, fit: ChannelFit) -> Regression:
    known, model = record.known, model_of(record, record.drive(), fit.terms)
    return Regression.of(
        model.design(fit.log_shapes),
        model.target,
        record.load_n[known],
        model.block,
        load_levels(record.load_n)[known],
        model.time_s if record.timed else None,
    )


def _refit(record: BenchRecord, fit: ChannelFit, rows: Regression, common: Common) -> ChannelFit:
    """The same terms and shapes by generalised least squares."""
    law = law_under(rows, common)
    offset, gain, _, slow, memory_s = np.exp(law)
    several = fit.sessions > 1

    def solve(design: FloatArray) -> BlockFit:
        found = fit_under(replace(rows, design=design), common, law)
        scaled = design / np.linalg.norm(design, axis=0)
        return BlockFit(
            coefficients=found.coefficients,
            covariance=found.covariance,
            dof=found.dof,
            sd_within=float(np.sqrt(found.variance * (1.0 + slow))),
            sd_between=float(np.sqrt(found.variance * offset)) if several else 0.0,
            rank=int(np.linalg.matrix_rank(scaled)),
            condition=float(np.linalg.cond(scaled)),
            sd_gain=float(np.sqrt(found.variance * gain)) / rows.load_rms_n if several else 0.0,
        )

    model = model_of(record, record.drive(), fit.terms)
    found = model.together(fit.log_shapes, float(memory_s) if common.lasting else 0.0, solve)
    return finish_channel(record, fit.terms, model, found)
