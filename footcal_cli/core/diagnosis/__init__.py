"""Diagnosis: what the simulation gets wrong, named, sized and proved, or honestly not."""
