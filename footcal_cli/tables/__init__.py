"""How a file on disk becomes a table: one unit and one name per column, whatever it was called.

`columns` declares the kinds of tables, `table` reads one; the rest are the steps of reading.
"""
