"""Loads typed between readings or among them: several units, and words where nothing lay."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from footcal_cli.app import main
from footcal_cli.records.files import read_record
from footcal_cli.records.results import ParametersRecord
from footcal_cli.tables.carried import Carried

N_PER_COUNT = 9.80665e-3 / 431.7
Shown = Callable[[str, list[int]], str]


def between(load: str, nothing: str, row: str) -> Shown:
    """A line for each load, or for none, above its readings."""

    def shown(said: str, read: list[int]) -> str:
        head = nothing if said == "" else load.format(said)
        return "\n".join([head, *(row.format(value) for value in read)]) + "\n"

    return shown


def among(separator: str, nothing: str, decimal: str = ".") -> Shown:
    """The load in the row of each reading, or a word."""

    def shown(said: str, read: list[int]) -> str:
        word = said.removesuffix(" g").replace(".", decimal) or nothing
        return "".join(f"{word}{separator}{value}\n" for value in read)

    return shown


GRAMS = ("", "100 g", "250.5 g", "500 g", "1000 g", "500 g", "")
KILOGRAMS = ("", "100 g", "250.5 g", "500 g", "1 kg", "0.5 kg", "")


@pytest.mark.parametrize(
    ("head", "shown", "said"),
    [
        ("Tare done\n", between("--- {} ---", "--- empty ---", "Raw: {}"), GRAMS),
        ("", between(">>> known weight: {}", ">>> TARE", "12:01:02 -> {}"), GRAMS),
        ("", between("placed {}", "removed all", "{}"), GRAMS),
        ("", between("weight = {}", "weight = none", "raw = {}"), GRAMS),
        ("", between("placed {}", "placed 0 g", "{}"), KILOGRAMS),
        ("", between("put {} on", "empty again", "read: {}"), KILOGRAMS),
        ("channel,raw\n", between("# {}", "# unloaded", "cell,{}"), KILOGRAMS),
        ("weight_g,raw\n", among(",", "empty"), GRAMS),
        ("Last [g];ADC\n", among(";", "leer", ","), GRAMS),
    ],
)
def test_every_load_holds_for_its_readings_and_a_word_for_none_is_none(
    head: str, shown: Shown, said: tuple[str, ...], tmp_path: Path
) -> None:
    rng = np.random.default_rng(1)
    text = head
    for load in said:
        number, unit = load.split() if load else ("0", "g")
        grams = float(number) * {"g": 1, "kg": 1000}[unit]
        text += shown(load, [round(84213 + 431.7 * grams + rng.normal(0, 25)) for _ in range(6)])
    (tmp_path / "log.txt").write_text(text, encoding="utf-8")
    recipe, out = tmp_path / "log.toml", tmp_path / "out"
    for words in (
        ["init", str(tmp_path / "log.txt"), "-o", str(recipe)],
        ["offline-fit", "--recipe", str(recipe), "--out", str(out), "--no-pictures"],
    ):
        with pytest.raises(SystemExit) as end:
            main(words)
        assert end.value.code in (0, None)
    found = read_record(ParametersRecord, out / "parameters.json").parameters
    (scale,) = (one.value for name, one in found.items() if name.endswith(".scale"))
    # a load of its neighbour's rows would move the scale by percents
    assert scale == pytest.approx(N_PER_COUNT, rel=1e-3)


def test_what_says_that_nothing_lies_there_leaves_the_other_columns() -> None:
    held = Carried(r"^(?P<load>\d+) g on (?P<cell>\w+)$|^(?P<zero_load>empty)$")
    for line in ("500 g on fl", "empty", "no such line"):
        held.takes(line)
    assert held.holds == {"load": "0", "cell": "fl"}
