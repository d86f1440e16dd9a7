"""Relations of worlds, robots and machines: frames, mirrors, names, scales, settings."""

from __future__ import annotations

import json
import locale
import os
import re
import time
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from tests.faults.bases import BASES, CELLS
from tests.faults.facts import Facts
from tests.faults.relations import GEOMETRY, ROUNDED, Relation, Words, bases_of, of_logs


def world_relations() -> list[Relation]:
    """All of them."""
    return [*_frames(), *_names(), *_settings()]


# frames of the world and of the robot


def _frames() -> Iterator[Relation]:
    def turned(angle: float, shift_m: tuple[float, float], log: pd.DataFrame) -> pd.DataFrame:
        c, s = np.cos(angle), np.sin(angle)
        for x in [n for n in log.columns if n.split("_x_")[0] in _WORLD and "_x_" in n]:
            y = x.replace("_x_", "_y_")
            moved = np.array(shift_m) if x.endswith("_x_m") else np.zeros(2)
            a, b = log[x].to_numpy(), log[y].to_numpy()
            log = log.assign(**{x: c * a - s * b + moved[0], y: s * a + c * b + moved[1]})
        for name in [n for n in log.columns if n.endswith("_foot_yaw_rad")]:
            log = log.assign(**{name: log[name] + angle})
        for stem in ("body_q", "base_q", "left_foot_q", "right_foot_q"):
            names = [f"{stem}{axis}" for axis in "xyzw"]
            if set(names) <= set(log.columns):
                spin = Rotation.from_rotvec([0.0, 0.0, angle])
                both = (spin * Rotation.from_quat(log[names].to_numpy())).as_quat()
                log = log.assign(**dict(zip(names, both.T, strict=True)))
        return log

    def opposite(log: pd.DataFrame) -> pd.DataFrame:
        names = [n for n in log.columns if n[:-1].endswith("_q")]
        return log.assign(**{n: -log[n] for n in names})

    def full_turn(log: pd.DataFrame) -> pd.DataFrame:
        return log.assign(phase_rad=log["phase_rad"] + 4 * np.pi)

    for name in ("stand", "walk", "pose", "apply_legs", "diagnose_walk"):
        for angle, shift_m in ((2.0, (0.0, 0.0)), (0.0, (3.0, -2.0)), (-0.7, (-1.0, 4.0))):
            yield Relation(
                f"world turned by {angle} rad and moved by {shift_m[0]:g}, {shift_m[1]:g} m",
                "frame", BASES[name], of_logs(partial(turned, angle, shift_m)), GEOMETRY,
                expected=partial(_turned_facts, angle, shift_m),
            )  # fmt: skip
    for name in ("pose", "apply_legs"):
        yield Relation("quaternions of the other sign", "frame", BASES[name], of_logs(opposite))
    for name in ("hang", "pose", "apply_legs"):
        yield Relation("shaft angles two turns on", "frame", BASES[name], of_logs(full_turn),
                       ROUNDED)  # fmt: skip
    for name in ("stand", "walk", "apply"):
        yield Relation(
            "the robot seen in a mirror", "mirror", BASES[name], _mirrored_world, GEOMETRY,
            expected=_mirrored_facts, words=name != "walk",
        )  # fmt: skip


def _turned_facts(angle: float, shift_m: tuple[float, float], facts: Facts) -> Facts:
    """Points in the world, of which a replay knows the mean, lie elsewhere; all else stays."""
    numbers, c, s = dict(facts.numbers), np.cos(angle), np.sin(angle)
    for x in [n for n in numbers if n.startswith("replay/") and n.endswith("_x_m")]:
        y = f"{x.removesuffix('_x_m')}_y_m"
        (a, _), (b, _) = numbers[x], numbers[y]
        # their spread along x is another one; each is judged by its own
        numbers[x] = (c * a - s * b + shift_m[0], -1.0)
        numbers[y] = (s * a + c * b + shift_m[1], -1.0)
    return Facts(numbers, facts.words)


_WORLD = frozenset({"com", "com_acc", "angmom_rate", "left_foot", "right_foot", "base"})


def _other_side(name: str) -> str:
    """The mirror image of a foot's or a cell's name."""
    side = {"left": "right", "right": "left"}
    corner = {"fl": "fr", "fr": "fl", "rl": "rr", "rr": "rl"}
    return "_".join(side.get(w, corner.get(w, w)) for w in name.split("_"))


def _mirrored(log: pd.DataFrame) -> pd.DataFrame:
    """y and what turns about x or z change sign; left and right change places."""
    for name in log.columns:
        if name.endswith(("_y_m", "_y_mps2", "_yaw_rad", "angmom_rate_x_nm")):
            log = log.assign(**{name: -log[name]})
    return log.rename(columns=_other_side)


def _mirrored_world(folder: Path, words: Words) -> Words:
    """Logs, and the calibration to start from: each cell's own belongs to its mirror image."""
    for word in [w for w in words if w.endswith(".json")]:
        record = json.loads(Path(word).read_text("utf-8"))
        known = record["parameters"]
        record["parameters"] = {
            ".".join(_other_side(part) for part in name.split(".")): p for name, p in known.items()
        }
        for block in record["covariance"]:
            block["names"] = [
                ".".join(_other_side(part) for part in name.split(".")) for name in block["names"]
            ]
        Path(word).write_text(json.dumps(record), "utf-8")
    return of_logs(_mirrored)(folder, words)


def _mirrored_facts(facts: Facts) -> Facts:
    numbers = {}
    for name, (value, sd) in facts.numbers.items():
        file, _, key = name.partition("/")
        other = ".".join(_other_side(part) for part in key.split("."))
        turned = key.endswith(("_y_m", "com_y", "com_correction_y"))
        # cycles are counted from the left foot's touchdowns: by half a step from the other's
        spread = np.inf if key == "gait_cycle" else sd
        numbers[f"{file}/{other}"] = (-value if turned else value, spread)
    return Facts(numbers, facts.words)


# names and scales that are the user's own


def _names() -> Iterator[Relation]:
    def renamed(log: pd.DataFrame) -> pd.DataFrame:
        return log.assign(channel="right" + log["channel"].str.removeprefix("left"))

    def own(facts: Facts) -> Facts:
        numbers = {n.replace("left_", "right_"): v for n, v in facts.numbers.items()}
        return Facts(numbers, facts.words)

    def permuted(log: pd.DataFrame) -> pd.DataFrame:
        return log.rename(columns={
            f"{a}_{kind}": f"{b}_{kind}" for a, b in zip(CELLS, _NEXT, strict=True)
            for kind in ("counts", "load_n")
        })  # fmt: skip

    def permuted_facts(facts: Facts) -> Facts:
        after = dict(zip(CELLS, _NEXT, strict=True))
        numbers = {}
        for name, number in facts.numbers.items():
            file, _, key = name.partition("/")
            cell, _, rest = key.partition(".")
            head, _, other = rest.partition("_from_")
            rest = f"{head}_from_{after[other]}" if other in after else rest
            numbers[f"{file}/{after.get(cell, cell)}.{rest}"] = number
        return Facts(numbers, facts.words)

    def counted(gain: float, zero: float, log: pd.DataFrame) -> pd.DataFrame:
        names = [n for n in log.columns if n.endswith("counts")]
        return log.assign(**{n: gain * log[n] + zero for n in names})

    def recounted(gain: float, zero: float, folder: Path, words: Words) -> Words:
        words = of_logs(partial(counted, gain, zero))(folder, words)
        for recipe in (Path(word) for word in words if word.endswith(".toml")):
            text = recipe.read_text("utf-8")  # the amplifier's nameplate goes with its counts
            for key, slope, added in (
                ("scale_n_per_count", 1.0 / gain, 0.0), ("zero_counts", gain, zero),
            ):  # fmt: skip
                given = re.search(rf"^{key} = (\S+)", text, re.MULTILINE)
                if given:
                    new = slope * float(given[1]) + added
                    text = text.replace(given[0], f"{key} = {new!r}")
            recipe.write_text(text, "utf-8")
        return words

    def scaled(gain: float, zero: float, facts: Facts) -> Facts:
        numbers = dict(facts.numbers)
        for name, (value, sd) in facts.numbers.items():
            if name.endswith(".scale") or "scale_from" in name:
                numbers[name] = (value / gain, sd / abs(gain))
        for name in [n for n in numbers if n.endswith(".bias")]:
            scale, _ = facts.numbers[name.replace(".bias", ".scale")]
            value, sd = numbers[name]
            # its sd is that of the force at zero counts, which lie elsewhere now
            numbers[name] = (value - scale * zero / gain, sd if zero == 0 else -1.0)
        return Facts(numbers, facts.words)

    yield Relation("cells of the other foot", "names", BASES["weights"], of_logs(renamed),
                   expected=own)  # fmt: skip
    yield Relation("cells in another order", "names", BASES["together"], of_logs(permuted),
                   ROUNDED, permuted_facts)  # fmt: skip
    for name in ("weights", "together", "stream"):
        for gain, zero in ((2.0, 0.0), (-1.0, 0.0), (1.0, 4096.0), (0.5, -1000.0)):
            yield Relation(
                f"counts times {gain:g} plus {zero:g}", "scale", BASES[name],
                partial(recounted, gain, zero), ROUNDED, partial(scaled, gain, zero),
                words=False,
            )  # fmt: skip


_NEXT = (*CELLS[3:], *CELLS[:3])


# what the machine and the command line are set to


def _settings() -> Iterator[Relation]:
    def elsewhere(folder: Path, words: Words) -> Words:
        os.chdir(folder)
        return [Path(word).name if Path(word).is_file() else word for word in words]

    def linked(folder: Path, words: Words) -> Words:
        store = folder / "store"
        store.mkdir()
        for word in words:
            path = Path(word)
            if path.is_file():
                path.rename(store / path.name)
                path.symlink_to(store / path.name)
        return words

    def timezone(folder: Path, words: Words) -> Words:
        os.environ["TZ"] = "Asia/Kathmandu"
        time.tzset()
        return words

    def commas(folder: Path, words: Words) -> Words:
        for name in ("de_DE.UTF-8", "fr_FR.UTF-8", "C"):
            try:
                locale.setlocale(locale.LC_ALL, name)
                break
            except locale.Error:
                continue
        return words

    def seed(folder: Path, words: Words) -> Words:
        return [*words, "--seed", "7"]

    def rewritten(folder: Path, words: Words) -> Words:
        for word in words:
            if word.endswith(".json"):
                content = json.loads(Path(word).read_text("utf-8"))
                turned: Mapping[str, object] = dict(reversed(content.items()))
                Path(word).write_text(json.dumps(turned), "utf-8")
        return words

    for base in bases_of("weights", "stand", "hang", "pose", "check_walk", "apply"):
        yield Relation("from another working folder", "settings", base, elsewhere)
    for base in bases_of("weights", "walk", "hang", "apply"):
        yield Relation("inputs are symbolic links", "settings", base, linked)
        yield Relation("in another time zone", "settings", base, timezone)
        yield Relation("in another locale", "settings", base, commas)
    for base in bases_of("weights", "together", "stream", "stand", "hang", "pose"):
        yield Relation("with another seed", "settings", base, seed)
    for base in bases_of("stand", "walk", "pose", "apply", "diagnose"):
        yield Relation("calibration with its keys turned round", "format", base, rewritten)
