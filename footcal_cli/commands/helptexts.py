"""What ``--help`` adds to each command: its group, the columns it reads, an example."""

from __future__ import annotations

_GROUPS = {
    "Look at logs": ("check", "init", "convert", "kinematics"),
    "Calibrate": ("offline-fit", "static-init", "online-replay", "hang-calib", "pose-calib"),
    "Use a calibration": ("apply", "export", "batch"),
    "Find out what is wrong": ("diagnose", "simulate", "effects", "schema"),
}
GROUP_OF = {name: group for group, names in _GROUPS.items() for name in names}
"""Command -> heading under which ``footcal --help`` lists it."""

_COLUMNS = {
    "offline-fit": "channel, load_n or load_kg, counts (session, time_s, direction, "
    "temperature_degc); placements: foot, placement, hole_x_m, hole_y_m, load_n, fl_counts ...",
    "static-init": "time_s, left_fl_counts ...; body: time_s, com_x_m ..., left_foot_x_m ...",
    "online-replay": "time_s, left_fl_counts ... or left_fx_n ...; body: time_s, com_x_m ..., "
    "com_acc_x_mps2 ..., left_foot_x_m ...",
    "hang-calib": "orientation, time_s, leg, phase_rad, fx_n ... tz_nm (temperature_degc)",
    "pose-calib": "pose, leg, phase_rad, fx_n ... tz_nm, body_qx ... body_qw (contact)",
    "apply": "those of the log to calibrate: time_s, left_fl_counts ... or fx_n ... tz_nm",
    "diagnose": "those of the experiment: weights, placements, stand, walk, hang or pose",
    "check": "those of any kind of log",
    "init": "any; the recipe maps them to footcal's names",
    "convert": "any; the columns written are named after topics and fields",
    "kinematics": "time_s, a column per joint of the URDF, base_qx ... base_qw or "
    "base_roll_rad ... (base_x_m ..., left_fz_n ...)",
    "simulate": "none; of a recorded MOTION: time_s, left_fl_n ..., com_x_m ..., left_foot_x_m ...",
    "batch": "session, logs (robot, date, operator, recipe, parameters)",
}
_EXAMPLES = {
    "offline-fit": "footcal offline-fit weights.csv --out out/cells",
    "static-init": "footcal static-init cells.parquet body.parquet --recipe robot.toml "
    "--parameters out/cells/parameters.json",
    "online-replay": "footcal online-replay cells.parquet body.parquet --recipe robot.toml "
    "--parameters out/cells/parameters.json",
    "hang-calib": "footcal hang-calib hang.parquet --recipe robot.toml --out out/hang",
    "pose-calib": "footcal pose-calib poses.parquet --recipe robot.toml "
    "--parameters out/hang/parameters.json",
    "apply": "footcal apply walk.parquet --recipe robot.toml "
    "--parameters out/cells/parameters.json",
    "diagnose": "footcal diagnose cells.parquet body.parquet --experiment walk "
    "--recipe robot.toml --parameters out/cells/parameters.json",
    "check": "footcal check log.csv --out out/check",
    "batch": "footcal batch sessions.csv --command offline-fit --recipe robot.toml",
    "init": "footcal init log.csv",
    "convert": "footcal convert walk.bag --list",
    "kinematics": "footcal kinematics joints.parquet --urdf robot.urdf",
    "simulate": "footcal simulate --recipe robot.toml --experiment walk --effect hysteresis=0.5",
    "export": "footcal export out/hang/parameters.json --to kth-yaml --sensor fl",
    "effects": "footcal effects hysteresis",
    "schema": "footcal schema diagnosis",
}


_INSTEAD_OF_JSON = {
    "convert": "--json is refused: the Parquet files are the answer, and the exit code says "
    "whether they are complete.",
    "effects": "--json is refused: the answer is a table of text; `footcal schema diagnosis` "
    "describes effects in JSON.",
    "export": "--json is refused: the file is the answer.",
    "schema": "--json is refused: the answer is JSON already.",
}
JSON_ANSWERS = frozenset(GROUP_OF) - frozenset(_INSTEAD_OF_JSON)
"""Commands that answer with one JSON where ``--json`` asks for it."""


def epilog_of(command: str) -> str:
    """The columns that a command reads, optional ones in brackets, and an example."""
    columns = f"Columns: {_COLUMNS[command]}\n\n" if command in _COLUMNS else ""
    answers = (
        "--json prints one JSON object instead: verdict, errors, findings, paths "
        "(`footcal schema answer`)."
    )
    answers = f"{_INSTEAD_OF_JSON.get(command, answers)}\n\n"
    example = f"Example: {_EXAMPLES[command]}" if command in _EXAMPLES else ""
    return f"{columns}{answers}{example}"
