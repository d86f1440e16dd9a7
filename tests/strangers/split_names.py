"""Benches whose cells or loads are named in parts: by two columns, letters, files, discs, steps.

Names of feet and cells, languages and separators differ; each writer is one layout.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from tests.strangers.rigs import Cell, G, Made, Rng, Truth, cell, truth_of, write

LADDER_KG = (0.0, 1.0, 2.0, 5.0, 10.0, 5.0, 2.0, 1.0, 0.0)


def _cells(rng: Rng, names: Sequence[str], kind: str = "hx_small") -> dict[str, Cell]:
    return {name: cell(rng, kind) for name in names}


def _by_two(
    cells: Mapping[str, Cell], pairs: Sequence[tuple[str, str]], rng: Rng, whole: bool = True
) -> list[tuple[str, str, float, float]]:
    """Rows of foot, cell, load in kg and reading, cell after cell."""
    kg = np.array(LADDER_KG)
    return [
        (foot, part, float(m), float(r))
        for (foot, part), one in zip(pairs, cells.values(), strict=True)
        for m, r in zip(kg, one.read(kg * G, rng, whole), strict=True)
    ]


def foot_and_cell(to: Path, rng: Rng) -> Made:
    """Two German feet of three cells, the foot and the cell in a column each, newtons and mV."""
    pairs = [(foot, part) for foot in ("li", "re") for part in ("vorn", "hl", "hr")]
    cells = _cells(rng, [f"{foot}_{part}" for foot, part in pairs], "volt")
    lines = [
        f"{foot};{part};{m * G:.4f};{r:.5f}".replace(".", ",")
        for foot, part, m, r in _by_two(cells, pairs, rng, whole=False)
    ]
    return Made([write(to / "kalibrierung.csv", ["Fuss;Zelle;Last_N;U_V", *lines])],
                truth_of(cells, 98))  # fmt: skip


def four_legs_of_numbers(to: Path, rng: Rng) -> Made:
    """Four legs by their letters, cells by their numbers, behind the load: ``LF``, ``2``."""
    pairs = [(leg, str(n)) for leg in ("LF", "RF", "LH", "RH") for n in (1, 2, 3)]
    cells = _cells(rng, [f"{leg}_{n}" for leg, n in pairs])
    lines = [f"{m:g},{leg},{n},{r:.0f}" for leg, n, m, r in _by_two(cells, pairs, rng)]
    return Made([write(to / "bench.csv", ["kg,leg,sensor,raw", *lines])], truth_of(cells, 98))


def foot_once_above_its_rows(to: Path, rng: Rng) -> Made:
    """A sheet whose merged cells name foot and cell once, the operator in every row."""
    pairs = [(foot, part) for foot in ("gauche", "droit") for part in ("avant", "arrière")]
    cells = _cells(rng, [f"{foot}_{part}" for foot, part in pairs])
    lines, last = [], ("", "")
    for foot, part, m, r in _by_two(cells, pairs, rng):
        said = ("" if foot == last[0] else foot, "" if (foot, part) == last else part)
        lines.append(f"{said[0]};{said[1]};PM;{m:g};{r:.0f}")
        last = (foot, part)
    return Made([write(to / "pesees.csv", ["pied;capteur;qui;masse_kg;brut", *lines])],
                truth_of(cells, 98))  # fmt: skip


def cells_of_two_persons(to: Path, rng: Rng) -> Made:
    """Two people loaded the same four cells: who did it names no cell."""
    cells = _cells(rng, ["c1", "c2", "c3", "c4"])
    kg = np.array(LADDER_KG)
    lines = [
        f"{who},{name},{m:g},{r:.0f}"
        for who in ("ana", "ben") for name, one in cells.items()
        for m, r in zip(kg, one.read(kg * G, rng), strict=True)
    ]  # fmt: skip
    return Made([write(to / "log.csv", ["operator,cell,load_kg,counts", *lines])],
                truth_of(cells, 98))  # fmt: skip


def letters_behind_a_letter(to: Path, rng: Rng) -> Made:
    """Four cells side by side, called by the foot's letter and their own: ``dA dB dC dD``."""
    cells = _cells(rng, ["da", "db", "dc", "dd"])
    grams = 1000 * np.tile(LADDER_KG, 2)
    read = [one.read(grams / 1000 * G, rng) for one in cells.values()]
    lines = ["\t".join(f"{v:.0f}" for v in row) for row in zip(grams, *read, strict=True)]
    return Made([write(to / "bancada.txt", ["peso_g\tdA\tdB\tdC\tdD", *lines])],
                truth_of(cells, 98))  # fmt: skip


def _lvm(
    to: Path, rng: Rng, names: Sequence[str], cells: Sequence[Cell], above: str = ""
) -> list[Path]:
    """A file each under lines of a header: load, mean and scatter of a bridge in mV."""
    paths = []
    for name, one in zip(names, cells, strict=True):
        kg = np.tile(LADDER_KG, 3)
        read = one.read(kg * G, rng, whole=False)
        lines = [f"{k};{m:.3f};{r:.5f};{rng.uniform(1e-3, 2e-3):.4f}".replace(".", ",")
                 for k, (m, r) in enumerate(zip(kg, read, strict=True), 1)]  # fmt: skip
        head = [f"{above};{name}"] if above else []
        paths.append(write(to / f"{name}.lvm", ["Messung", "Speisung_V;5,000", *head, "",
                                                "Nr;Masse_kg;U_mV;s_mV", *lines]))  # fmt: skip
    return paths


def _bridge(rng: Rng, scale: float) -> Cell:
    return Cell(scale, float(rng.uniform(-3, 3)), 2e-4)


def files_numbered_by_cell(to: Path, rng: Rng) -> Made:
    """``Z1`` … ``Z3`` name file and specimen; two scales are alike to 0.1 %."""
    names = ["Z1", "Z2", "Z3"]
    cells = [_bridge(rng, scale) for scale in (39.5, 39.46, 38.8)]
    truth = truth_of(dict(zip(names, cells, strict=True)), 98)
    return Made(_lvm(to, rng, names, cells, "Prüfling"), truth)


def files_numbered_without_a_word(to: Path, rng: Rng) -> Made:
    """``K01`` … ``K04``, nothing above the table: only the lines say that they are four cells."""
    names = ["K01", "K02", "K03", "K04"]
    cells = [_bridge(rng, scale) for scale in (39.5, 40.3, 38.8, 41.0)]
    return Made(_lvm(to, rng, names, cells), truth_of(dict(zip(names, cells, strict=True)), 98))


def runs_of_one_cell(to: Path, rng: Rng) -> Made:
    """``t1`` … ``t3`` of one cell, whose zero is another one after each mounting."""
    scale = 39.5
    cells = [Cell(scale, bias, 2e-4) for bias in (1.0, 1.3, 0.9)]
    truth = Truth({".scale": scale}, {".scale": 0.005 * scale})
    return Made(_lvm(to, rng, ["t1", "t2", "t3"], cells), truth)


def labels_of_discs(to: Path, rng: Rng) -> Made:
    """Displays in kg beside what lay there (``D1+D2``), and a table of the discs in French."""
    masses = {"D1": 1.0003, "D2": 1.9991, "D3": 2.0004, "D4": 4.9987}
    table = [f"{name};{kg:.4f}".replace(".", ",") for name, kg in masses.items()]
    cells = _cells(rng, ["c_1", "c_2", "c_3"], "newton")
    paths = [write(to / "disques.csv", ["disque;masse_kg", *table])]
    for serie, order in enumerate((("D1", "D2", "D1+D2"), ("D3", "D3+D1", "D4"), ("D4+D3",)), 1):
        said = ["-", *order, "D1+D2+D3+D4", *order[::-1], "-"]
        kg = np.array([sum(masses.get(part, 0.0) for part in word.split("+")) for word in said])
        read = [one.read(kg * G, rng, whole=False) / G for one in cells.values()]
        lines = [";".join([f"{k}", word, *(f"{v:.4f}" for v in row)]).replace(".", ",")
                 for k, (word, *row) in enumerate(zip(said, *read, strict=True), 1)]  # fmt: skip
        head = "etape;masse_posee;C1_kg;C2_kg;C3_kg"
        paths.append(write(to / f"serie_{serie}.csv", [head, *lines]))
    return Made(paths, truth_of(cells, 98))


def weights_by_their_names(to: Path, rng: Rng) -> Made:
    """One cell under named weights, ``2x A`` among them, the table in grams."""
    grams = {"A": 500.0, "B": 1000.0, "C": 2000.0}
    one = cell(rng)
    said = ["none", "A", "B", "2x A & B", "C", "B and C", "C", "A", "none"] * 2
    sums = {"none": 0.0, "2x A & B": 2000.0, "B and C": 3000.0, **grams}
    kg = np.array([sums[word] for word in said]) / 1000
    lines = [f"{word},{r:.0f}" for word, r in zip(said, one.read(kg * G, rng), strict=True)]
    table = write(to / "weights.csv", ["weight,mass_g", *(f"{k},{v:g}" for k, v in grams.items())])
    return Made([write(to / "log.csv", ["put_on,raw", *lines]), table], truth_of(one, 30))


def steps_in_a_sheet(to: Path, rng: Rng) -> Made:
    """A recording of each cell by its own clock, and a sheet of cell, mass, start and end in ms.

    Between the steps a hand moves the weights; the recordings differ in length.
    """
    cells = _cells(rng, ["A", "B", "C"])
    sheet, paths = ["celula,passo,massa_kg,inicio_ms,fim_ms"], []
    for k, (name, one) in enumerate(cells.items()):
        begins, lines = 3000 + 411 * k, ["# HX711 10SPS", "millis,bruto"]
        now = float(begins)
        for step, kg in enumerate(LADDER_KG, 1):
            held, moved = float(rng.uniform(9e3, 12e3)), float(rng.uniform(3e3, 4e3))
            sheet.append(f"{name},{step},{kg:g},{now + moved:.0f},{now + moved + held:.0f}")
            for at in np.arange(now, now + moved + held, 100.0):
                put = kg * G if at > now + moved - 300 else float(rng.uniform(0, 100))
                lines.append(f"{at:.0f},{one.read(np.array(put), rng):.0f}")
            now += moved + held
        paths.append(write(to / f"log_celula_{name}.txt", lines))
    return Made([write(to / "folha.csv", sheet), *paths], truth_of(cells, 98))


SPLIT_NAMES = (
    foot_and_cell, four_legs_of_numbers, foot_once_above_its_rows, cells_of_two_persons,
    letters_behind_a_letter, files_numbered_by_cell, files_numbered_without_a_word,
    runs_of_one_cell, labels_of_discs, weights_by_their_names, steps_in_a_sheet,
)  # fmt: skip
