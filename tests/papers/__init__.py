"""Both source papers again: every table and figure that data can draw, printed value beside ours.

``python -m tests.papers`` runs footcal's own functions on robots with the papers' settings and
writes ``docs/papers.md`` with its pictures. Pieces that take long are kept under ``--out``; what is
there is not run again.
"""
