"""Six-axis transducers hanging in the air: offsets, weight, CoM, tilt (seed 2, III-A)."""
