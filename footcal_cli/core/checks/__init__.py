"""What one log says against itself before anything is calibrated; `footcal check` asks for it.

Each check states a law that every sound log obeys (a weight stays the same, a plate balances, load
passes from foot to foot) and speaks where the log breaks it by far more than sensors are uncertain.
"""
