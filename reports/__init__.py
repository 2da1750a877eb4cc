"""Figures and films of runs: what the solver and the suites wrote, drawn and not computed again."""
