"""Readers of foreign files: recordings of robots and laboratories as plain streams of columns.

One module per kind of file, each with ``streams(path, clock)``; imported by ``commands/convert``
only. A library that reads one kind is imported when a file of that kind is opened.
"""
