"""Standing poses: how the transducers are mounted, and what they show ([Wu], section III-B)."""
