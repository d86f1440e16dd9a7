"""A diagnosis in words, tables and its record."""
