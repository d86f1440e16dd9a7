"""Standing poses: how the transducers are mounted, and what they show (seed 2, section III-B)."""
