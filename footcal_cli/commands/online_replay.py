"""``footcal online-replay``: self-calibration along a recorded walk ([NAO], 3.3.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from footcal_cli.commands.options import command
from footcal_cli.recipe.options import OnlineReplayOptions

if TYPE_CHECKING:
    from footcal_cli.core.online.streams import MergeRule
    from footcal_cli.intake.recordings import Recording
    from footcal_cli.report.outcome import Outcome
    from footcal_cli.session.session import Session


@command(OnlineReplayOptions)
def online_replay(session: Session[OnlineReplayOptions]) -> Outcome:
    """Track scales and biases of foot sensors along a recorded walk."""
    from footcal_cli.core.online.streams import MergeRule
    from footcal_cli.errors import UsageError
    from footcal_cli.intake.recordings import read_recordings
    from footcal_cli.intake.walk_length import is_long_walk

    options = session.options
    rule = MergeRule(
        delay_s=options.delay_s,
        cutoff_hz=options.cutoff_hz,
        causal=options.causal,
        largest_acc_mps2=options.largest_acceleration_mps2,
        min_force_n=options.min_force_n,
    )
    if _in_parts(options) and is_long_walk(session):
        return _long(session, rule)
    with session.step("read"):
        recordings = read_recordings(session, rule, "walk")
    if len(recordings) > 1:
        raise UsageError(
            f"{len(recordings)} walks given, one is replayed at a time",
            remedy="name one sensor log and its body log, or use batch for many",
        )
    if recordings[0].belief is None:
        if options.method != "memory":
            raise UsageError(
                f"method '{options.method}' knows load cells only", remedy="use --method memory"
            )
        return _on_transducers(session, recordings[0])
    return _on_cells(session, recordings[0])


def _in_parts(options: OnlineReplayOptions) -> bool:
    """Whether a long walk may run in parts; what compares methods or spans needs all of it."""
    whole = options.compare or options.sensitivity or options.picture_span_s is not None
    return options.method == "memory" and not whole


def _on_cells(session: Session[OnlineReplayOptions], recording: Recording) -> Outcome:
    from dataclasses import replace

    import numpy as np

    from footcal_cli.core.online.comparison import compare
    from footcal_cli.core.online.memory import memory_estimates
    from footcal_cli.core.online.weighed import as_unsure_as_weighed
    from footcal_cli.core.study.windows import QUIET_S
    from footcal_cli.errors import DataError
    from footcal_cli.intake.walk import baseline_of, paper_methods, settings_of, truth_of
    from footcal_cli.session.calibration import feet_calibration
    from footcal_cli.sheets.walk import outcome_of
    from footcal_cli.sheets.walk_tables import frames_of
    from footcal_cli.tables.logfiles import write_parquet_pieces

    options, merged, belief = session.options, recording.merged, recording.belief
    robot = session.recipe.robot
    assert belief is not None, "looked at by the caller"
    settings = settings_of(options, merged, belief, robot.weight_n or 53.0)
    truth_n, baseline = truth_of(session, merged.log.time_s, belief.channels), baseline_of(session)
    with session.step("replay"):
        papers = paper_methods(options, merged, belief)
        found = compare(
            merged, belief, settings, truth_n=truth_n, baseline=baseline,
            others=None if papers is None else papers.replayed,
            rng=np.random.default_rng(session.request.seed),
        )  # fmt: skip
    if options.method not in found.replayed:
        raise DataError(
            f"method '{options.method}' takes its weights from standing still, and this log starts "
            f"with less than {QUIET_S} s of it",
            remedy="record half a second of standing before the first step, or give force_weight "
            "and cop_weight in [online_replay]",
        )
    with session.step("evidence"):
        wanted = options.compare if options.sensitivity is None else options.sensitivity
        curves = papers.sensitivity(found) if wanted and papers is not None else []
    estimates = memory_estimates(found.memory, belief)
    estimates = as_unsure_as_weighed(estimates, found.weighed.shared_sd(robot.mass_share_sd))
    if papers is not None:
        session.note(papers.findings())
        if options.method != "memory":
            estimates = papers.estimates(options.method, belief)
    session.note(found.findings())

    return replace(
        outcome_of(found, papers, curves, robot, recording, options),
        parameters=feet_calibration(session, estimates),
        files={"replay.parquet": lambda path: write_parquet_pieces(frames_of(found), path)},
    )


def _long(session: Session[OnlineReplayOptions], rule: MergeRule) -> Outcome:
    """Learn in one part, then run all of them in order; `replay.parquet` grows with them."""
    from dataclasses import replace

    import numpy as np

    from footcal_cli.core.online.memory import memory_estimates
    from footcal_cli.core.online.parts import WalkInParts
    from footcal_cli.core.online.weighed import as_unsure_as_weighed
    from footcal_cli.intake.long_walks import LongWalk
    from footcal_cli.intake.walk import baseline_of, settings_of, truth_path
    from footcal_cli.session.calibration import feet_calibration
    from footcal_cli.session.run_files import set_aside
    from footcal_cli.sheets.walk import outcome_of
    from footcal_cli.sheets.walk_tables import frames_of

    options, robot = session.options, session.recipe.robot
    streams = LongWalk.of(session, rule, options.update_hz, truth_path(session))
    with session.step("learn"):
        teacher, belief = streams.teacher(causal=options.causal)
        settings = settings_of(options, teacher.own, belief, robot.weight_n or 53.0)
        walk = WalkInParts(belief, settings, teacher, baseline_of(session))
        del teacher

    def pieces(advance: Callable[[float], None]) -> Iterator[dict[str, object]]:
        parts = streams.parts()
        while (part := next(parts, None)) is not None:
            size, found = part.stop - part.start, walk.take(part)
            del part
            yield from frames_of(found)
            del found
            advance(size)

    with session.counted("replay", "samples", streams.samples) as advance:
        move = set_aside(pieces(advance), "replay.parquet")
    with session.step("evidence"):
        found = walk.finish(np.random.default_rng(session.request.seed))
        recording = streams.recording(found.merged)
    session.note(found.findings())
    estimates = memory_estimates(found.memory, belief)
    estimates = as_unsure_as_weighed(estimates, found.weighed.shared_sd(robot.mass_share_sd))
    return replace(
        outcome_of(found, None, [], robot, recording, options),
        parameters=feet_calibration(session, estimates),
        files={"replay.parquet": move},
    )


def _on_transducers(session: Session[OnlineReplayOptions], recording: Recording) -> Outcome:
    from dataclasses import replace

    from footcal_cli.core.online.six_axis_replay import replay_six_axis
    from footcal_cli.session.calibration import feet_calibration
    from footcal_cli.sheets.six_axis_walk import outcome_of

    options, merged = session.options, recording.merged
    with session.step("replay"):
        found = replay_six_axis(
            merged,
            samples_per_update=max(round(merged.rate_hz / options.update_hz), 1),
            scales=options.scales,
        )
    return replace(
        outcome_of(found, session.recipe.robot.name, recording),
        parameters=feet_calibration(session, found.estimates),
    )
