"""The bench: known weights on load cells, on their own and under a foot."""
