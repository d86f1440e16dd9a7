"""Many sessions: planned from a glob or a table, run by local processes or a Dask cluster."""
