"""Figures of a diagnosis: what is left, whether it is chance, and what the effect changes."""
