"""The foot paper's walks: three speeds, several trials of several sessions, every method.

The motion and the ground's forces come from a physics engine (``sample_data/physics/biped.py``),
cells and telemetry from footcal's chain with the paper's rates, delay and noise. A session is a
mounting of the feet: cells 2 % and 0.3 N (1 sd) off their nameplate, a body model that is exact or
whose CoM is 2 mm (1 sd) off, and a bench calibration of the mounted cells under weights up to 30 N,
which is the paper's offline baseline. A trial is a motion with other steps, and other noise.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from footcal_cli.core.bench.regression import fit_affine
from footcal_cli.core.effects import find_effect
from footcal_cli.core.experiments.walk import channel_contact
from footcal_cli.core.log import Log
from footcal_cli.core.online.belief import Belief, nameplate
from footcal_cli.core.online.comparison import ReplayedWalk, ReplaySettings, compare
from footcal_cli.core.online.memory import MemoryOptions
from footcal_cli.core.online.merging import merge_cells
from footcal_cli.core.online.noise import starting_noise
from footcal_cli.core.online.streams import BodyStream, Merged, SensorStream
from footcal_cli.core.online.tuning import LEARNT
from footcal_cli.core.parameters import Estimates, Status
from footcal_cli.core.simulation.bench_logs import WeightsPlan
from footcal_cli.core.simulation.plans import Plans, Spread
from footcal_cli.core.simulation.recorded import motion_columns
from footcal_cli.core.simulation.robots import Biped
from footcal_cli.core.simulation.scenario import EffectRequest, Scenario, calibration, simulate
from footcal_cli.core.study.sensitivity import window_sensitivity
from footcal_cli.core.study.walk import PaperMethods
from footcal_cli.core.study.window import Weights, WindowRule, run_window
from footcal_cli.core.study.windows import GivenWeights
from footcal_cli.plots.walk import plot_cop, plot_vgrf
from tests.papers.statistics import converged_after

Array = NDArray[np.float64]
ROOT = Path(__file__).resolve().parents[2]
SPEEDS_MPS = (0.02, 0.04, 0.1)
BODIES = {"exact": 0.0, "2 mm off": 0.002}
"""Body model -> sd of its CoM error, m, drawn once per session."""
SHOWN_BODY = "exact"
SESSIONS, TRIALS = 6, 2
FIRST_MOTION, MOTIONS = 41, 6
METHODS = ("before", "static", "window", "memory", "smoother")
FIGURE_SPAN_S = (40.0, 46.0)


@dataclass(frozen=True)
class Trial:
    """One walk of one session."""

    body: str
    speed_mps: float
    session: int
    trial: int

    @property
    def motion_seed(self) -> int:
        """Seed of the engine's steps: the trials of a session have different ones."""
        return FIRST_MOTION + (self.session * TRIALS + self.trial) % MOTIONS

    @property
    def name(self) -> str:
        """Stem of its files."""
        body = self.body.replace(" ", "_")
        return f"walk_{1e3 * self.speed_mps:03.0f}_{self.session}{self.trial}_{body}"


def trials(sessions: int = SESSIONS, per_session: int = TRIALS) -> Iterator[Trial]:
    """All walks, speed by speed."""
    for body, speed in product(BODIES, SPEEDS_MPS):
        for session, number in product(range(sessions), range(per_session)):
            yield Trial(body, speed, session, number)


def motion_of(trial: Trial, folder: Path, seconds: float = 60.0) -> dict[str, Array]:
    """The engine's motion, made where it is not there yet."""
    path = folder / str(trial.motion_seed) / f"motion_walk_{trial.speed_mps:g}.parquet"
    if not path.exists():
        sys.path.insert(0, str(ROOT / "sample_data" / "physics"))
        from biped import walk, write_motion

        path.parent.mkdir(parents=True, exist_ok=True)
        write_motion(walk(trial.speed_mps, seconds, trial.motion_seed), path)
    table = pd.read_parquet(path)
    columns = {name: table[name].to_numpy(dtype=float) for name in motion_columns(Biped())}
    return columns | {"time_s": columns["time_s"] - columns["time_s"][0]}


@cache
def mounted(session: int) -> tuple[Mapping[str, float], Estimates]:
    """True scales and biases of a session, and the bench calibration of the mounted cells."""
    robot, seed = Biped(), 500 + session
    _, values = calibration(robot, Spread(), seed)
    weighed = simulate(
        "weights", robot, Plans(weights=WeightsPlan(sessions=1)), [], seed=seed, given=values
    ).files["weights"]
    channel = np.asarray(weighed["channel"]).astype(str)
    fits = []
    for name in robot.channels:
        own = channel == name
        fits.append(fit_affine(name, _number(weighed["load_n"])[own],
                               _number(weighed["counts"])[own]).estimates)  # fmt: skip
    names = tuple(n for fit in fits for n in fit.names)
    size = len(names)
    return values, Estimates(
        names, tuple(u for fit in fits for u in fit.units),
        np.concatenate([fit.values for fit in fits]), np.zeros((size, size)),
        (Status.ESTIMATED,) * size,
    )  # fmt: skip


def _number(values: Any) -> Array:
    return np.asarray(values, dtype=float)


def recorded_walk(trial: Trial, motion: Mapping[str, Array]) -> Scenario:
    """What cells and telemetry show of the motion."""
    values, _ = mounted(trial.session)
    drawn = np.random.default_rng([trial.session, 27]).normal(0.0, BODIES[trial.body], 2)
    wrong = EffectRequest(
        find_effect("com_offset"), None,
        {"com_correction_x": float(drawn[0]), "com_correction_y": float(drawn[1])},
    )  # fmt: skip
    seed = 1000 * round(1e3 * trial.speed_mps) + 10 * trial.session + trial.trial
    return simulate("walk", Biped(), Plans(), [wrong], seed=seed, given=values, motion=motion)


def merged_of(scenario: Scenario, robot: Biped) -> tuple[Merged, Belief, Array]:
    """Streams as `online-replay` merges them, the nameplate's belief, and the true loads."""
    cells, body, loads = (scenario.files[name] for name in ("cells", "body", "true_loads"))
    feet = tuple(robot.feet)

    def columns(*names: str) -> Array:
        return np.stack([_number(body[name]) for name in names], axis=-1)

    stream = BodyStream(
        _number(body["time_s"]),
        columns(*(f"com_{a}_m" for a in "xyz")),
        columns(*(f"com_acc_{a}_mps2" for a in "xyz")),
        columns(*(f"angmom_rate_{a}_nm" for a in "xy")),
        np.stack([columns(*(f"{foot}_foot_{a}_m" for a in "xyz")) for foot in feet], axis=1),
        columns(*(f"{foot}_foot_yaw_rad" for foot in feet)),
    )
    counts = np.stack([_number(cells[f"{name}_counts"]) for name in robot.channels], axis=-1)
    scale = np.full(len(robot.channels), robot.scale_n_per_count)
    belief = nameplate(robot.channels, scale, -scale * robot.zero_counts, 0.02, 0.3)
    merged = merge_cells(
        SensorStream(_number(cells["time_s"]), counts, robot.channels), stream, belief,
        tuple(robot.cells_m(foot) for foot in feet), robot.mass_kg, robot.gravity_mps2,
    )  # fmt: skip
    truth = np.stack([_number(loads[f"{name}_n"]) for name in robot.channels], axis=-1)
    return merged, belief, truth


def replayed(trial: Trial, motion: Mapping[str, Array]) -> tuple[ReplayedWalk, PaperMethods]:
    """All methods on one walk."""
    merged, belief, truth = merged_of(recorded_walk(trial, motion), Biped())
    _, baseline = mounted(trial.session)
    return compared_methods(merged, belief, truth, baseline, seed=trial.motion_seed)


def compared_methods(
    merged: Merged,
    belief: Belief,
    truth_n: Array,
    baseline: Estimates,
    *,
    seed: int,
    learnt: tuple[str, ...] = LEARNT,
) -> tuple[ReplayedWalk, PaperMethods]:
    """`online-replay --compare` with its defaults; `learnt` says which noise is learnt."""
    idle = channel_contact(merged.log) == 0.0
    raw_n = merged.raw * np.abs(belief.scale_n_per_count)
    start = starting_noise(raw_n, idle, Biped().weight_n)
    settings = ReplaySettings(memory=MemoryOptions(noise=start, learnt=learnt))
    rng = np.random.default_rng(seed)
    papers = PaperMethods.run(
        merged.log, belief, ("window", "static"), WindowRule(), GivenWeights()
    )
    found = compare(
        merged, belief, settings, truth_n=truth_n, baseline=baseline, others=papers.replayed,
        rng=rng,
    )  # fmt: skip
    return found, papers


def figures_of(found: ReplayedWalk, trial: Trial, folder: Path) -> None:
    """CoP and force of the two papers' methods over the offline baseline (Figs. 10–15)."""
    judged = tuple(one for one in found.judged if one.reference == "baseline")
    against = replace(found, judged=judged)
    folder.mkdir(parents=True, exist_ok=True)
    stem = f"{1e3 * trial.speed_mps:03.0f}"
    shown = ("static", "window", "memory")
    plot_cop(against, shown, FIGURE_SPAN_S).savefig(folder / f"walk_{stem}_cop.png", dpi=110)
    plot_vgrf(against, shown, FIGURE_SPAN_S).savefig(folder / f"walk_{stem}_vgrf.png", dpi=110)


def summary_of(found: ReplayedWalk, papers: PaperMethods, trial: Trial) -> dict[str, Any]:
    """The numbers that the page needs of one walk."""
    start = _cycle_starts(found.cycle, found.merged.log.time_s)
    errors = [
        {
            "method": one.method, "reference": one.reference,
            "cop_m": one.rms("cop"), "vgrf_n": one.rms("vgrf"),
            "cycle_cop_m": float(np.nanmean(one.cycles("cop"))),
            "cycle_cop_sd_m": float(np.nanstd(one.cycles("cop"), ddof=1)),
            "converged_s": converged_after(one.cycles("cop"), start[: one.cycles("cop").size]),
        }
        for one in found.judged
        if one.reference != "motion" and one.method in METHODS
    ]  # fmt: skip
    channels = found.belief.channels
    values, _ = mounted(trial.session)
    final = {}
    for method in ("static", "window", "memory"):
        own = found.replayed[method]
        late = slice(2 * len(found.merged.log) // 3, None)
        true = np.array([values[f"{name}.scale"] for name in channels])
        bias = np.array([values[f"{name}.bias"] for name in channels])
        gain = true / found.belief.scale_n_per_count - 1.0
        offset = bias - found.belief.bias_n * (1.0 + gain)
        final[method] = {
            "gain_error": float(np.sqrt(np.nanmean((own.gain[-1] - gain) ** 2))),
            "bias_error_n": float(np.sqrt(np.nanmean((own.bias_n[-1] - offset) ** 2))),
            "gain_steady_sd": float(np.median(np.std(own.gain[late], axis=0))),
            "bias_steady_sd_n": float(np.median(np.std(own.bias_n[late], axis=0))),
        }
    return {
        "body": trial.body, "speed_mps": trial.speed_mps,
        "session": trial.session, "trial": trial.trial,
        "errors": errors, "parameters": final,
        "settling": [
            {"name": s.name, "converged_s": s.converged_s, "drift_per_hour": s.drift_per_hour,
             "drift_sd": s.drift_sd}
            for s in found.settling
        ],
        "omega": {m: [float(np.asarray(x)) for x in (w.force, w.cop, w.smooth)]
                  for m, one in papers.windowed.items() for w in (one.weights,)},
        "cycles": int(found.cycle.max()) + 1,
    }  # fmt: skip


def _cycle_starts(cycle: NDArray[np.int64], time_s: Array) -> Array:
    first = [int(np.argmax(cycle == k)) for k in range(int(cycle.max()) + 1)]
    return np.asarray(time_s[first])


def sensitivity_of(found: ReplayedWalk, papers: PaperMethods) -> list[dict[str, Any]]:
    """CoP and force error against the baseline as ωF, ωP, ωS are scaled by 0.2 … 5."""
    curves = window_sensitivity(
        found.merged.log,
        found.belief,
        papers.windowed["window"].weights,
        found.replayed["baseline"],
    )
    return [
        {"setting": c.setting, "factor": c.factors.tolist(), "cop_m": c.cop_m.tolist(),
         "vgrf_n": c.vgrf_n.tolist()}
        for c in curves
    ]  # fmt: skip


def milliseconds_per_update(log: Log, belief: Belief, weights: Weights) -> dict[str, float]:
    """CPU time of one update of eq. (14): compiled loops, and plain NumPy."""
    part = log.rows(0, min(len(log), 1600))
    spent = {}
    for name, fast in (("compiled", True), ("numpy", False)):
        run_window(part.rows(0, 80), belief, weights, fast=fast)  # compile first
        start = time.process_time()
        track = run_window(part, belief, weights, fast=fast)
        spent[name] = 1e3 * (time.process_time() - start) / track.time_s.size
    return spent


def run_walks(
    out: Path, sessions: int = SESSIONS, per_session: int = TRIALS
) -> list[dict[str, Any]]:
    """Every walk, done ones read back."""
    done = []
    for trial in trials(sessions, per_session):
        path = out / "walks" / f"{trial.name}.json"
        if not path.exists():
            found, papers = replayed(trial, motion_of(trial, out / "motions"))
            summary = summary_of(found, papers, trial)
            if (trial.session, trial.trial, trial.body) == (0, 0, SHOWN_BODY):
                figures_of(found, trial, out / "pictures")
                summary["sensitivity"] = sensitivity_of(found, papers)
                log, weights = found.merged.log, papers.windowed["window"].weights
                summary["ms_per_update"] = milliseconds_per_update(log, found.belief, weights)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps(summary, indent=1), encoding="utf-8")
        done.append(json.loads(path.read_text("utf-8")))
    return done
