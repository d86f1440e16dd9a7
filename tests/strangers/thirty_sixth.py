"""Six axes of new labs: units in notes, poses by number, plugs, files of legs, words for forces."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.strangers.rigs import Array, G, Made, Rng, rows, tool_truth, wrist, write
from tests.strangers.thirty_fifth import leg_truth, legs, swings

UP = {"+x": [-1.0, 0, 0], "-x": [1.0, 0, 0], "+z": [0, 0, -1.0], "-z": [0, 0, 1.0]}
"""Axis of a body that points up, and gravity in it."""
AXES = "fx,fy,fz,mx,my,mz"


def kilograms_in_notes(to: Path, rng: Rng) -> Made:
    """Means of a wrist in kgf and kgf cm, which the notes say and the header does not."""
    made, wrench, rot = wrist(rng, 24, 1)
    read = wrench / ([G] * 3 + [G / 100] * 3)
    names = "no,qw,qx,qy,qz,FX,FY,FZ,MX,MY,MZ"
    body = rows(np.arange(1, 25), *np.roll(rot.as_quat(), 1, axis=1).T, *read.T, form="%.5f")
    notes = write(to / "notes.md", ["# kensa", "", "- `FX FY FZ` [kgf], `MX MY MZ` [kgf.cm]."])
    return Made([write(to / "kensa.csv", [names, *body]), notes], tool_truth(made))


def long_poses_and_hanging(to: Path, rng: Rng) -> Made:
    """A row for each leg: of a hanging in which one joint moves, and of poses by their number."""
    turned = {"LP": 45.0, "PP": -45.0, "LT": -45.0, "PT": 45.0}
    made = legs(rng, {n: Rotation.from_euler("z", a, degrees=True) for n, a in turned.items()})
    hung, stood = [f"gora,t,noga,udo,{AXES}"], [f"pozycja,noga,q_w,q_x,q_y,q_z,odw,udo,{AXES}"]
    for up, down in UP.items():
        for name, leg in made.items():
            angle = swings(120)
            read = leg.read(angle, np.array(down), rng)
            body = rows(0.125 * np.arange(120), angle, *read.T, form="%.5f")
            hung += [f"{up},{t},{name},{rest}" for t, rest in (r.split(",", 1) for r in body)]
    for pose in range(1, 21):
        trunk = Rotation.from_euler("xyz", rng.normal(0.0, 0.15, 3))
        share = rng.dirichlet([6.0] * len(made)) * 80.0
        quat = np.roll(trunk.as_quat(), 1)
        for (name, leg), load in zip(made.items(), share, strict=True):
            angle = rng.normal(0.0, 0.3, 1)
            push: Array = leg.mount.inv().apply(trunk.inv().apply([0.0, 0.0, load]))
            read = leg.read(angle, trunk.inv().apply([0.0, 0.0, -1.0]), rng)[0]
            read = read + np.r_[push, np.cross([0.02, 0.05, -0.3], push)]
            numbers = [*quat, rng.normal(0.0, 0.4), angle[0], *read]
            stood.append(f"{pose},{name}," + ",".join(f"{v:.5f}" for v in numbers))
    paths = [write(to / "pozycje.csv", stood), write(to / "zwis.csv", hung)]
    return Made(paths, leg_truth(made))


def files_of_foreign_legs(to: Path, rng: Rng) -> Made:
    """A file for each leg and attitude: legs and ways by letters of a language, no word known."""
    turned = Rotation.from_matrix([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
    made = legs(rng, dict.fromkeys(("LP", "PP", "LZ", "PZ"), turned))
    paths = []
    for name, leg in made.items():
        for up, down in UP.items():
            angle = swings(150)
            read = leg.read(angle, np.array(down), rng)
            body = rows(0.1 * np.arange(150), np.degrees(angle), *read.T, sep=";", form="%.4f")
            names = "cas_s;kycel_deg;Fx_N;Fy_N;Fz_N;Mx_Nm;My_Nm;Mz_Nm"
            word = up[1] + ("N" if up[0] == "+" else "D")
            paths.append(write(to / f"{name}_{word}.csv", [names, *body]))
    return Made(paths, leg_truth(made))


def words_for_forces(to: Path, rng: Rng) -> Made:
    """A file for each attitude of four legs: components as OpenSim writes them, in Dutch."""
    made = legs(rng, {n: Rotation.identity() for n in ("LV", "RV", "LA", "RA")})
    ends = ("kracht_vx", "kracht_vy", "kracht_vz", "moment_x", "moment_y", "moment_z")
    names = ["time", *(f"{n}_heup" for n in made), *(f"{n}_{e}" for n in made for e in ends)]
    paths = []
    for up, down in UP.items():
        angle = swings(160)
        read = [leg.read(angle, np.array(down), rng) for leg in made.values()]
        body = rows(0.08 * np.arange(160), *[angle] * 4, *np.hstack(read).T, sep="\t", form="%.5f")
        word = f"ophang_{up[1]}_{'omhoog' if up[0] == '+' else 'omlaag'}"
        head = [word, "version=1", "nRows=160", "nColumns=29", "inDegrees=no", "endheader"]
        paths.append(write(to / f"{word}.mot", [*head, "\t".join(names), *body]))
    return Made(paths, leg_truth({name.lower(): leg for name, leg in made.items()}))


def plugs(to: Path, rng: Rng) -> Made:
    """Six numbers of each plug in gf and gf cm, angles in tenths of a degree by its number."""
    made = legs(rng, {f"J{n}": Rotation.identity() for n in (1, 2, 3)})
    names = ["ms", *(f"ph{n}" for n in (1, 2, 3)), *(f"{j}_{i}" for j in made for i in range(6))]
    paths = []
    for k, down in enumerate(UP.values()):
        angle = np.linspace(0.0, 2 * np.pi, 240)
        read = [
            leg.read(angle + np.radians(5.0 * i), np.array(down), rng)
            / ([1e-3 * G] * 3 + [1e-5 * G] * 3) for i, leg in enumerate(made.values())
        ]  # fmt: skip
        tenths = np.round(10 * np.degrees(angle))
        body = rows(100 * np.arange(240), tenths, tenths + 50, tenths + 100, *np.hstack(read).T,
                    form="%.1f")  # fmt: skip
        paths.append(write(to / f"LOG_{k:02d}.CSV", [",".join(names), *body]))
    notes = write(to / "README.md", ["forces en gramme-force, moments en gramme-force.cm"])

    def fill(recipe: str) -> str:
        said = zip(range(4), ("-x", "+x", "-z", "+z"), strict=True)
        named = ", ".join(f'"LOG_{k:02d}.CSV" = "{axis}"' for k, axis in said)
        own = f"orientation = {{ file_name = '^(.+)$', names = {{ {named} }} }}"
        return recipe.replace("[columns]\n", f"[columns]\n{own}\n", 1)

    return Made([*paths, notes], leg_truth(made), "which axis points down", fill=fill)


THIRTY_SIXTH = (
    kilograms_in_notes,
    long_poses_and_hanging,
    files_of_foreign_legs,
    words_for_forces,
    plugs,
)
