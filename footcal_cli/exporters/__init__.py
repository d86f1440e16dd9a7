"""Calibrations in the form that robot software reads: ``parameters.json`` to its own files.

One module per consumer, each with ``export(calibration, names)`` that cites the consumer's
documentation; imported by ``commands/export`` only. Nothing here reads or writes a file but
``matlab``, whose ``.mat`` SciPy writes.
"""
