"""Self-calibration while walking: the paper's window and the estimator that remembers."""
