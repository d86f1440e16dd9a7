"""The contract of what footcal finds: golden outputs of every shipped recipe and sample."""
