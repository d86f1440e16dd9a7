"""`pose-calib`: what each of its three fits says: mountings, offsets again, pairs in series."""
