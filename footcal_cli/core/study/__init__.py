"""The papers' own methods, kept to be compared with: no fit of the product imports them.

[NAO]'s sliding window and static assumption, [Wu]'s stepwise hanging fit and alternating mounting.
"""
