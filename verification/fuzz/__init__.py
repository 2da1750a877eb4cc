"""Fuzzers: many random tries of what must never happen, every one from a seed of its own."""
