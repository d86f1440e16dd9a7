"""footcal: calibration of robots that feel the ground.

Conventions, once for the whole project
---------------------------------------
Units
    SI everywhere: N, Nm, m, s, rad, kg. A scalar, column, option or JSON key carries its unit as
    suffix (``load_n``, ``time_s``). Raw readings are ``counts``. Gravity is 9.80665 m/s² unless
    the recipe's ``[robot]`` says otherwise.
Frames
    x forward, y left, z up. ``w`` world (z against gravity), ``b`` robot body, ``c`` body at the
    centre of mass, ``t`` transducer. ``rot_bw`` maps vectors from world to body axes;
    ``force_w_n`` is a force in world axes. A foot frame lies on the sole, x to the toe.
Signs
    Vertical ground reaction force is positive upward on the robot. Load cells:
    ``F = scale · S + bias`` with S in counts, so that a pressed cell reads positive F whatever the
    sign of its scale. Six-axis transducers: ``reading = applied wrench + offset``, wrench order
    [fx fy fz tx ty tz]. A residual is measured − predicted, and an error is estimate − truth.
Names
    Cells ``left_fl left_fr left_rl left_rr right_fl …`` (front/rear, left/right), legs
    ``fl ml hl fr mr hr`` (front, middle, hind). Parameters ``<channel, leg or robot>.<name>``.
    GLOSSARY.md has the rest.
Symbols
    S counts, F force, c scale, d bias, p centre of pressure (CoP), m mass, g gravity, L angular
    momentum about the centre of mass, φ shaft angle of a leg.
Papers
    [NAO] is "NAO CoP self-calibration", [Wu] is Wu & Revzen; CITATION.cff has both in full.
Tables
    `footcal_cli.tables.columns` declares the columns of every kind of log.
"""

__version__ = "1.1.0"
NEW_OBJECTS = 200_000
"""So many between two searches for garbage: imports make 160,000 and leave none."""
