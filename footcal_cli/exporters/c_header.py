"""A C header: load cells as ``force = scale · counts + bias``, transducers as matrix and offset.

C99 and C++; no library is needed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from footcal_cli.errors import UsageError
from footcal_cli.exporters.contract import LINEAR, Exported, ToExport, head, number


def export(calibration: ToExport, names: Mapping[str, str]) -> Exported:
    """Tables of cells and transducers, and a function that applies a row of each.

    Raises
    ------
    UsageError
        Two sensors whose names become the same identifier.
    """
    cells = {n: t for n, t in names.items() if n in calibration.cells}
    transducers = {n: t for n, t in names.items() if n not in cells}
    warnings = calibration.beyond(list(names), LINEAR)
    comments = head(
        calibration,
        names,
        ["Cells: force N = scale * counts + bias, positive when pressed. Transducers: wrench =",
         "matrix * (reading - offset), [fx fy fz tx ty tz] in N and Nm, in the nominal frame."],
        warnings,
    )  # fmt: skip
    lines = [
        *(f"/* {line.replace('*/', '* /')} */" for line in comments),
        "#ifndef FOOTCAL_CALIBRATION_H", "#define FOOTCAL_CALIBRATION_H", "",
    ]  # fmt: skip
    if cells:
        lines += _cells(calibration, cells)
    if transducers:
        lines += _transducers(calibration, transducers)
    return Exported("\n".join([*lines, "#endif"]) + "\n", warnings)


def _cells(calibration: ToExport, names: Mapping[str, str]) -> list[str]:
    rows = []
    for name, theirs in names.items():
        scale, bias = calibration.values(name, ["scale", "bias"])
        rows.append(f'    {{"{_text(theirs)}", {number(scale)}, {number(bias)}}},')
    return [
        "typedef struct {",
        "    const char *name;",
        "    double scale_n_per_count; /* N/count */",
        "    double bias_n;            /* N */",
        "} footcal_cell;", "",
        *_enumeration("FOOTCAL_CELL", names),
        "static const footcal_cell footcal_cells[] = {", *rows, "};", "",
        "/* Force on a cell in N from its raw counts. */",
        "static inline double footcal_force_n(const footcal_cell *cell, double counts)",
        "{", "    return cell->scale_n_per_count * counts + cell->bias_n;", "}", "",
    ]  # fmt: skip


def _transducers(calibration: ToExport, names: Mapping[str, str]) -> list[str]:
    rows = []
    for name, theirs in names.items():
        offset = ", ".join(number(x) for x in calibration.offset(name))
        matrix = ",\n      ".join(
            "{" + ", ".join(number(x) for x in row) + "}"
            for row in calibration.matrix(name, LINEAR)
        )
        rows.append(f'    {{"{_text(theirs)}",\n     {{{offset}}},\n     {{{matrix}}}}},')
    return [
        "typedef struct {",
        "    const char *name;",
        "    double offset[6];    /* N, N, N, Nm, Nm, Nm */",
        "    double matrix[6][6]; /* 1, m and 1/m */",
        "} footcal_transducer;", "",
        *_enumeration("FOOTCAL_TRANSDUCER", names),
        "static const footcal_transducer footcal_transducers[] = {", *rows, "};", "",
        "/* Applied wrench [fx fy fz tx ty tz] in N and Nm from a reading. */",
        "static inline void footcal_wrench(const footcal_transducer *transducer,",
        "                                  const double reading[6], double wrench[6])",
        "{",
        "    for (int i = 0; i < 6; ++i) {",
        "        wrench[i] = 0.0;",
        "        for (int j = 0; j < 6; ++j)",
        "            wrench[i] += transducer->matrix[i][j] * (reading[j] - transducer->offset[j]);",
        "    }",
        "}", "",
    ]  # fmt: skip


def _enumeration(prefix: str, names: Mapping[str, str]) -> list[str]:
    words = [
        f"{prefix}_{re.sub(r'[^A-Za-z0-9]', '_', theirs).upper()}" for theirs in names.values()
    ]
    twice = [word for word in words if words.count(word) > 1]
    if twice:
        raise UsageError(f"two sensors would both be {twice[0]}",
                         remedy="name one otherwise: --sensor NAME=OTHER")  # fmt: skip
    return ["enum {", *(f"    {word}," for word in words), f"    {prefix}_COUNT", "};", ""]


def _text(name: str) -> str:
    return name.replace("\\", "\\\\").replace('"', '\\"')
