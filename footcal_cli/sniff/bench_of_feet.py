"""Known weights on the cells of several feet in one table: a column names the foot of each row.

Room: sniff; asked by weights.
"""

from __future__ import annotations

from dataclasses import replace

from footcal_cli.sniff.groups import slug
from footcal_cli.sniff.guesses import ColumnGuess, FileGuess, codes_of, numbers_of
from footcal_cli.sniff.names import name_guess
from footcal_cli.sniff.plan import Entry, LogPlan, extras, load_entry, reading_entry
from footcal_cli.sniff.which_cell import followers


def on_each_foot(
    file: FileGuess, load: ColumnGuess, label: ColumnGuess, foot: ColumnGuess,
    cells: list[ColumnGuess],
) -> LogPlan | None:  # fmt: skip
    """A bench of several feet in one table: the readings are those of the foot that a row names."""
    names = {word: name_guess(word).address for word in foot.words}
    if len(foot.words) < 2 or len({*names.values()}) < len(names) or not all(names.values()):
        return None
    entry, asked = load_entry(replace(load, held=load.held or label.held))
    wide: dict[str, dict[str, Entry]] = {}
    for at, word in enumerate(foot.words):
        rows = codes_of(foot) == at
        here = [replace(c, values=numbers_of(c)[rows]) for c in cells]
        only = replace(label, codes=codes_of(label)[rows])
        on = followers(replace(load, values=numbers_of(load)[rows]), only, here)
        if len(on) < len(label.words):
            return None
        wide |= {
            f"{names[word]}_{slug(cell.column)}": {
                "load_n": replace(entry, only_where={foot.column: word, label.column: loaded}),
                "counts": reading_entry(cell),
            }
            for loaded, cell in on.items()
        }
    return LogPlan(
        file, f"known weights on one of {len(wide)} cells of {len(names)} feet at a time",
        "a load, the foot and the cell it lies on, and several readings in a row", "likely",
        "offline-fit", "weights", extras(file), tuple(wide), wide, blanks=asked,
    )  # fmt: skip
