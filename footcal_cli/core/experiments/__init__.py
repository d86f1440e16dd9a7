"""The experiments: what each one physically knows, and the balance it demands."""
