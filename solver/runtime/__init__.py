"""Processes, and what a result depends on."""
