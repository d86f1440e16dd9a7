"""Sheets: results of the core as tables and sentences of a report."""
