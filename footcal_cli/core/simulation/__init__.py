"""Known truths through the chain: what the sensors of a robot would have shown."""
