"""`online-replay` on load cells: its options as the core wants them, and what it compares with."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.core.experiments.walk import channel_contact
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.comparison import ReplaySettings
from footcal_cli.core.online.memory import MemoryOptions
from footcal_cli.core.online.noise import WalkNoise, starting_noise
from footcal_cli.core.online.streams import Merged
from footcal_cli.core.online.tuning import LEARNT
from footcal_cli.core.parameters import Estimates, FloatArray
from footcal_cli.core.signals import interpolate_stream
from footcal_cli.core.study.walk import PaperMethods
from footcal_cli.core.study.window import WindowRule
from footcal_cli.core.study.windows import GivenWeights
from footcal_cli.session.request import read_calibration
from footcal_cli.tables.columns import truth_table
from footcal_cli.tables.table import read_table

if TYPE_CHECKING:
    from footcal_cli.recipe.options import OnlineReplayOptions
    from footcal_cli.session.session import Session


def settings_of(
    options: OnlineReplayOptions, merged: Merged, belief: Belief, weight_n: float
) -> ReplaySettings:
    """How the walk is replayed; learning starts from what its idle cells show."""
    idle = channel_contact(merged.log) == 0.0
    start = starting_noise(merged.raw * np.abs(belief.scale_n_per_count), idle, weight_n)
    noise, learn = noise_of(options, start)
    every = max(round(merged.rate_hz / options.update_hz), 1)
    return ReplaySettings(
        memory=MemoryOptions(
            states=options.states,
            plate=options.hanging_plate,
            swing=options.swing_rows,
            noise=noise,
            learnt=learn,
            samples_per_update=every,
            align=options.align_delay,
        ),
        min_force_n=options.min_force_n,
        causal=options.causal,
    )


def paper_methods(
    options: OnlineReplayOptions, merged: Merged, belief: Belief
) -> PaperMethods | None:
    """Those that run: all to compare, else the one that was asked for; None for none."""
    every = max(round(merged.rate_hz / options.update_hz), 1)
    asked = [m for m in ("window", "static") if options.compare or m == options.method]
    if not asked and not options.sensitivity:
        return None
    rule = WindowRule(
        samples=max(round(options.window_s * merged.rate_hz), every),
        every=every,
        foot_length_m=options.foot_length_m,
        min_force_n=options.min_force_n,
    )
    given = GivenWeights(options.force_weight, options.cop_weight, options.smooth_weight)
    return PaperMethods.run(merged.log, belief, asked, rule, given)


def noise_of(options: OnlineReplayOptions, start: WalkNoise) -> tuple[WalkNoise, tuple[str, ...]]:
    """The recipe's noise where it gives one, and the names of what is to be learnt."""
    given = {k: v for k, v in options.noise.model_dump().items() if v is not None}
    return replace(start, **given), tuple(name for name in LEARNT if name not in given)


def truth_path(session: Session[OnlineReplayOptions]) -> Path | None:
    """File of the true cell forces, from --truth or ``[data]``."""
    given = session.options.truth
    if given is not None:
        return Path(given)
    known = session.recipe.data.get("truth") and not session.request.logs
    return session.recipe.data_paths("truth")[0] if known else None


def truth_of(
    session: Session[OnlineReplayOptions], time_s: FloatArray, channels: tuple[str, ...]
) -> FloatArray | None:
    """True cell forces at the samples, from --truth or ``[data]``; None where there are none."""
    path = truth_path(session)
    if path is None:
        return None
    table = read_table(
        path, truth_table(channels), {}, gravity_mps2=session.recipe.robot.gravity_mps2
    )
    session.inputs[path.name] = table.digest
    stamps = table.number("time_s")
    values = table.numbers([f"{channel}_n" for channel in channels])
    longest = 5.0 * float(np.median(np.diff(stamps)))
    merged, good = interpolate_stream(stamps, values, time_s, max_gap_s=longest)
    return np.where(good[:, None], merged, np.nan)


def baseline_of(session: Session[OnlineReplayOptions]) -> Estimates | None:
    """The offline calibration to compare with, from --baseline."""
    if session.options.baseline is None:
        return None
    path = Path(session.options.baseline)
    if not path.is_absolute() and session.recipe.path is not None and not path.is_file():
        path = session.recipe.path.parent / path
    return read_calibration(path).estimates
