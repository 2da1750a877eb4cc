"""Verification cases, one module a suite; ``corovec.verification.registry`` collects them."""
