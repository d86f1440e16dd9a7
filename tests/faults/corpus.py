"""The corpus: which mutations meet which files, drawn by seed."""

from __future__ import annotations

import shutil
from collections.abc import Collection
from pathlib import Path

import numpy as np

from tests.faults.bases import BASES, Base, build
from tests.faults.judging import Case, call
from tests.faults.mutations import FILES, FORCES, LOGS, PARAMETERS, RECIPES, Mutation


def possible() -> list[tuple[str, str, Mutation]]:
    """Base case, file and mutation: every pair that makes sense."""
    found: list[tuple[str, str, Mutation]] = []
    for base in BASES.values():
        if base.values_only:
            values = [m for m in LOGS if m.family == "value"]
            found += [(base.name, log, m) for log in base.logs for m in values]
            continue
        for log in base.logs:
            bends = (*FILES, *LOGS) if log.endswith(".csv") else FILES
            found += [(base.name, log, m) for m in bends]
            # a body stream has no forces; the weighing of check has nothing to compare with
            if base.name in {"weights", "placements", "together", "hang", "pose", "apply_legs"}:
                found += [
                    (base.name, log, m)
                    for m in FORCES
                    # legs a quarter as heavy may be another robot's: nothing states their weight
                    if (base.name, m.name.partition(" ")[0]) != ("hang", "lbf")
                ]
        if base.recipe:
            found += [(base.name, base.recipe, m) for m in (*FILES, *RECIPES)]
        if base.model:
            found += [(base.name, base.model, m) for m in FILES]
        if base.parameters:
            found += [(base.name, base.parameters, m) for m in (*FILES, *PARAMETERS)]
    return found


def drawn(count: int, seed: int) -> list[Case]:
    """Cases in an order drawn by seed; each pair once before any comes again."""
    pairs = possible()
    cases = []
    for number in range(count):
        again, place = divmod(number, len(pairs))
        if place == 0:
            order = np.random.default_rng((seed, again)).permutation(len(pairs))
        base, file, mutation = pairs[order[place]]
        own = int(np.random.default_rng((seed, again, place)).integers(2**31))
        cases.append(Case(BASES[base], file, mutation, own))
    return cases


def prepared(folder: Path, bases: Collection[Base] = tuple(BASES.values())) -> Path:
    """The inputs, and what comes out of them unbent."""
    inputs = build(folder, bases)
    references = inputs / "references"
    if references.is_dir():
        return inputs
    fresh = inputs / "fresh"
    shutil.rmtree(fresh, ignore_errors=True)
    fresh.mkdir()
    for base in bases:
        if not base.calibrates:
            continue
        words = [str(inputs / w) if w in base.files else w for w in base.words]
        out = inputs / "run"
        code, _, err = call([*words, "--out", str(out)])
        if code not in (0, 1):
            raise RuntimeError(f"base case {base.name} ended with {code}: {err}")
        (made,) = out.glob("*parameters*.json")  # a missed gate gives it another name
        shutil.copy(made, fresh / f"{base.name}.json")
        shutil.rmtree(out)
    fresh.rename(references)
    return inputs
