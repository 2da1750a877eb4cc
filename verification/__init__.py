"""Verification suites of the solver."""
