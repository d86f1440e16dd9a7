"""Tests of the guessing of unknown logs, piece by piece."""
