"""Six-axis transducers hanging in the air: offsets, weight, CoM, tilt ([Wu], III-A)."""
