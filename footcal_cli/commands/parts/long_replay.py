"""`online-replay` of a walk too long to be held: part by part, written as it goes."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from footcal_cli.commands.parts.feet_parameters import feet_parameters
from footcal_cli.commands.parts.replay_settings import baseline_of, settings_of, truth_path
from footcal_cli.core.online.belief import Belief
from footcal_cli.core.online.memory import memory_estimates
from footcal_cli.core.online.parts import ENOUGH_CYCLES, Part, Walk
from footcal_cli.core.online.streams import MergeRule
from footcal_cli.intake.long_walks import LongWalk
from footcal_cli.records.results import FindingRecord
from footcal_cli.report import Report
from footcal_cli.session.run_folder import scratch
from footcal_cli.session.session import Outcome
from footcal_cli.sheets import walk as sheets
from footcal_cli.sheets.streams import stream_findings
from footcal_cli.tables.table import write_parquet_pieces

if TYPE_CHECKING:
    from footcal_cli.commands.online_replay import OnlineReplayOptions
    from footcal_cli.session.session import Session


def replay_long(session: Session[OnlineReplayOptions], rule: MergeRule) -> Outcome:
    """Learn in one part, then run all of them in order; `replay.parquet` grows with them."""
    options, robot = session.options, session.recipe.robot
    streams = LongWalk.of(session, rule, options.update_hz, truth_path(session))
    with session.step("learn"):
        teacher, belief = _teacher(streams.again(), causal=options.causal)
        settings = settings_of(options, teacher.own, belief, robot.weight_n or 53.0)
        walk = Walk(belief, settings, teacher, baseline_of(session))
        del teacher
    written = scratch() / "replay.parquet"

    def pieces(advance: Callable[[float], None]) -> Iterator[dict[str, object]]:
        parts = streams.parts()
        while (part := next(parts, None)) is not None:
            size, found = part.stop - part.start, walk.take(part)
            del part
            yield from sheets.frames_of(found)
            del found
            advance(size)

    with session.counted("replay", "samples", streams.samples) as advance:
        write_parquet_pieces(pieces(advance), written)
    with session.step("evidence"):
        found = walk.finish(np.random.default_rng(session.request.seed))
        recording = streams.recording(found.merged)
    findings = [*stream_findings(recording), *map(FindingRecord.of, found.findings())]

    def move(path: Path) -> None:
        shutil.move(written, path)

    return Outcome(
        report=Report(
            title=f"Walking calibration of {robot.name}, {recording.name}",
            verdict=sheets.verdict_of(found, options.method),
            pictures=sheets.pictures_of(found, [], robot),
            sheets=sheets.sheets_of(found),
            findings=tuple(findings),
            footer=sheets.footer_of(found, options.delay_s),
        ),
        rmse=sheets.rmse_of(found),
        parameters=feet_parameters(session, memory_estimates(found.memory, belief)),
        files={"replay.parquet": move},
        stage=options.method,
        reference=found.best_reference,
    )


def _teacher(streams: LongWalk, *, causal: bool) -> tuple[Part, Belief]:
    """The first part with gait cycles enough to learn from, else the one with most of them.

    A live run can learn from its beginning alone.
    """
    best: Part | None = None
    for part in streams.parts():
        if best is None or part.cycles > best.cycles:
            best = part
        if causal or best.cycles >= ENOUGH_CYCLES:
            break
    assert best is not None, "a stream has a part"
    assert streams.belief is not None
    return best, streams.belief
