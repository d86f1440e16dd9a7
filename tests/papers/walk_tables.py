"""Tables 4 to 6 of the foot paper over several trials, its open points, and its weights."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from footcal_cli.core.parameters import FloatArray
from tests.papers import printed
from tests.papers.formats import p_shown, picture, shown, table
from tests.papers.statistics import Paired, holm, paired, spread
from tests.papers.walks import BODIES, SPEEDS_MPS

Walk = Mapping[str, Any]
NAMES = {"static": "static (Han)", "window": "window, eq. (14)"}
METHODS = ("before", "static", "window", "memory")
QUANTITIES = (("cop_m", "CoP", 1e3, 0), ("vgrf_n", "vGRF", 1.0, 1))


def error_of(walk: Walk, method: str, reference: str, kind: str) -> float:
    """One figure of one walk: an RMS error, its spread over gait cycles, a settling time."""
    return next(
        float(e[kind])
        for e in walk["errors"]
        if (e["method"], e["reference"]) == (method, reference)
    )


def chosen(walks: Sequence[Walk], body: str, speed: float | None = None) -> list[Walk]:
    """Walks of one body model, and of one speed."""
    return [w for w in walks if w["body"] == body and speed in (None, w["speed_mps"])]


def compared(
    walks: Sequence[Walk], ours: str, theirs: str, kind: str, reference: str = "baseline"
) -> Paired:
    """Errors of two methods over the same sessions, the trials of a session taken together."""
    return paired(
        by_session(walks, [error_of(w, ours, reference, kind) for w in walks]),
        by_session(walks, [error_of(w, theirs, reference, kind) for w in walks]),
    )


def by_session(walks: Sequence[Walk], errors: Sequence[float]) -> FloatArray:
    """Geometric mean of the trials of each session: they share their cells, shape (sessions,)."""
    session = np.array([walk["session"] for walk in walks])
    return np.array(
        [np.exp(np.mean(np.log(errors), where=session == s)) for s in np.unique(session)]
    )


def walking_tables(walks: Sequence[Walk]) -> str:
    """Tables 4 to 6 with mean ± sd over trials, and paired tests."""
    rows = []
    for body in BODIES:
        for speed in SPEEDS_MPS:
            own = chosen(walks, body, speed)
            for method in METHODS:
                row = [body, f"{speed:g}", NAMES.get(method, method)]
                for kind, _, factor, place in QUANTITIES:
                    told = printed.TABLES_4_TO_6[speed].get(method)
                    row.append("–" if told is None else shown(factor * told[place]))
                    for reference in ("baseline", "truth"):
                        values = [factor * error_of(w, method, reference, kind) for w in own]
                        row.append(_mean_sd(values))
                rows.append(row)
    head = (
        "body model", "m/s", "method", "CoP printed (mm)", "against the offline calibration",
        "against the truth", "vGRF printed (N)", "against the offline calibration",
        "against the truth",
    )  # fmt: skip
    sessions = len({walk["session"] for walk in walks})
    count = len(chosen(walks, next(iter(BODIES)), SPEEDS_MPS[0]))
    return (
        table(head, rows)
        + f"\n\nRMS error once settled (the first 5 s left out), mean ± sd over {count} walks of a "
        f"minute: {sessions} sessions with other cells and, where the body model is 2 mm off, "
        f"another CoM error each; {count // sessions} trials per session with other steps. "
        "*before*: the nameplate. The offline calibration errs too: it comes from a bench and "
        "the same cells. Where the CoM of the body model is wrong, the window follows it.\n\n"
        + _tests(walks, sessions)
    )


def _mean_sd(values: Sequence[float]) -> str:
    return f"{shown(float(np.mean(values)))} ± {shown(float(np.std(values, ddof=1)), 2)}"


def _tests(walks: Sequence[Walk], sessions: int) -> str:
    done = [
        (body, speed, ours, theirs, unit, compared(chosen(walks, body, speed), ours, theirs, kind))
        for body in BODIES
        for ours, theirs in (("window", "static"), ("memory", "window"))
        for kind, unit, _, _ in QUANTITIES
        for speed in SPEEDS_MPS
    ]
    rows = [
        (
            body, f"{ours} / {theirs}", unit, f"{speed:g}",
            _printed_ratio(ours, theirs, unit, speed),
            f"{t.ratio:.2f} [{t.low:.2f}, {t.high:.2f}]", p_shown(p), p_shown(t.wilcoxon_p),
        )
        for (body, speed, ours, theirs, unit, t), p in zip(
            done, holm([entry[-1].t_p for entry in done]), strict=True
        )
    ]  # fmt: skip
    return (
        "Errors against the offline calibration, paired over sessions (the trials of a session "
        f"share their cells and count once: n = {sessions}; ratios and t test on logarithms, p "
        "after Holm for all rows; the signed-rank test cannot go below "
        f"{2.0 ** (1 - sessions):.3f}):\n\n"
        + table(
            ("body model", "errors of", "of", "m/s", "printed", "ratio [95 %]", "p, t test",
             "p, signed rank"),
            rows,
        )
    )  # fmt: skip


def _printed_ratio(ours: str, theirs: str, unit: str, speed: float) -> str:
    row = printed.TABLES_4_TO_6[speed]
    if ours not in row or theirs not in row:
        return "–"
    place = 0 if unit == "CoP" else 1
    return f"{row[ours][place] / row[theirs][place]:.2f}"


def walk_figures() -> list[str]:
    """Figs. 10 to 15."""
    return [
        picture(f"walk_{1e3 * speed:03.0f}_{kind}",
                f"Fig. {number}: {title} at {speed:g} m/s, methods over the offline calibration "
                "(black)")
        for speed, numbers in zip(SPEEDS_MPS, ((10, 11), (12, 13), (14, 15)), strict=True)
        for kind, number, title in zip(
            ("cop", "vgrf"), numbers, ("CoP", "vertical force"), strict=True
        )
    ]  # fmt: skip


def open_points(walks: Sequence[Walk]) -> str:
    """Convergence, steady state, repeatability over cycles, trials and sessions; drift."""
    rows = []
    for body in BODIES:
        own = chosen(walks, body)
        for method in ("static", "window", "memory"):
            times = np.array([error_of(w, method, "baseline", "converged_s") for w in own])
            known = times[np.isfinite(times)]
            cycles = [1e3 * error_of(w, method, "baseline", "cycle_cop_sd_m") for w in own]
            parts = [
                spread(
                    [1e3 * error_of(w, method, "baseline", "cop_m") for w in at],
                    [w["session"] for w in at],
                )
                for at in (chosen(walks, body, speed) for speed in SPEEDS_MPS)
            ]
            within, between = (
                float(np.sqrt(np.mean([getattr(one, name) ** 2 for one in parts])))
                for name in ("within_sd", "between_sd")
            )
            state = {k: float(np.mean([w["parameters"][method][k] for w in own]))
                     for k in own[0]["parameters"][method]}  # fmt: skip
            rows.append(
                (
                    body, NAMES.get(method, method),
                    _settled(known, times.size),
                    shown(float(np.mean(cycles)), 2), shown(within, 2), shown(between, 2),
                    f"{shown(100 * state['gain_steady_sd'], 2)} %, "
                    f"{shown(1e3 * state['bias_steady_sd_n'], 2)} mN",
                    f"{shown(100 * state['gain_error'], 2)} %, "
                    f"{shown(1e3 * state['bias_error_n'], 2)} mN",
                )
            )  # fmt: skip
    head = (
        "body model", "method", "CoP error settled after", "sd over gait cycles (mm)",
        "between trials (mm)", "between sessions (mm)", "steady sd of scale, bias",
        "error of scale, bias at the end",
    )  # fmt: skip
    return (
        table(head, rows)
        + "\n\nSettled: from then on every gait cycle's CoP error stays below mean + 2 sd of the "
        "last third; in how many walks it does. Between trials and sessions: components of "
        "variance of the CoP error, speeds apart. The simulated cells do not drift; memory "
        f"states, as far as a minute can say: {_drift(walks)}."
    )


def _settled(times_s: FloatArray, walks: int) -> str:
    return f"{np.median(times_s):.0f} s, {times_s.size} of {walks}" if times_s.size else "–"


def _drift(walks: Sequence[Walk]) -> str:
    told = []
    for kind, factor, unit in (("gain", 1e2, "%"), ("bias", 1.0, "N")):
        states = [s for w in walks for s in w["settling"] if s["name"].endswith(f".{kind}")]
        value, sd = (np.array([s[k] for s in states]) for k in ("drift_per_hour", "drift_sd"))
        inside = 100 * float(np.mean(np.abs(value) < 2 * sd))
        told.append(
            f"{kind} {shown(factor * float(np.median(np.abs(value))), 2)} {unit} per hour, median "
            f"size, {inside:.0f} % within 2 of its sd"
        )
    return "; ".join(told)


def sensitivity(walks: Sequence[Walk]) -> str:
    """Weights × 0.2 … 5, and time per update."""
    rows = [
        [f"{walk['speed_mps']:g}", curve["setting"], name, *(shown(factor * x) for x in curve[key])]
        for walk in walks
        for curve in walk.get("sensitivity", ())
        for name, key, factor in (("CoP (mm)", "cop_m", 1e3), ("vGRF (N)", "vgrf_n", 1.0))
    ]
    plain, compiled = (milliseconds(walks, name) for name in ("numpy", "compiled"))
    return (
        table(("m/s", "weight", "RMSE", "× 0.2", "× 0.5", "× 1", "× 2", "× 5"), rows)
        + "\n\nExact body model, first walk of each speed, against the offline calibration; "
        "`online-replay --compare` writes the same for any walk (`sensitivity.parquet`). The paper "
        "prints no numbers, only that results vary smoothly.\n\nTime per update (up to five "
        f"Gauss-Newton iterations on 0.5 s): printed {printed.MS_PER_UPDATE} ms; "
        f"{shown(plain, 2)} ms in NumPy, {shown(compiled, 2)} ms compiled (CPU time, one core of "
        "a small server)."
    )


def milliseconds(walks: Sequence[Walk], name: str) -> float:
    """Median CPU time per update of eq. (14)."""
    return float(np.median([w["ms_per_update"][name] for w in walks if "ms_per_update" in w]))
