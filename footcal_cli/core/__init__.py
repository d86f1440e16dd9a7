"""The numeric core: NumPy and SciPy only; arrays in, frozen dataclasses out.

No files, no printing, no clocks, no global state.
"""
