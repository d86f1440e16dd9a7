"""How the tables of a session become the arrays that the core takes, experiment by experiment."""
