"""Fits, noise, scores and evidence that every command shares; all rest on one residual."""
