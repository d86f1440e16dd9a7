"""Figures of a diagnosis: the residual, whether chance explains it, and what the effect changes."""
