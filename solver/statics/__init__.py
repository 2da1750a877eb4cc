"""Equilibrium: linear solution, load control, arc length."""
