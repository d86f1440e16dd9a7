"""The table of effects, one module per stage of the chain."""
