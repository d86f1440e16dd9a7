"""What a log of unknown origin looks like: layout, columns, experiment; never certain."""
