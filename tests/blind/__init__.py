"""The sealed bench: effects hidden in logs whose generators are not the inverse of footcal.

`worlds` make experiments, `foreign` distorts them, `injections` sets the sizes, `ledger` seals the
truth, `bench` plans, hides, diagnoses and scores, `page` writes what came out.
"""
