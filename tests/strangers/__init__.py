"""Logs in the shapes that people have, made by seed with the truth they were made from."""
