"""Verification cases, one module a suite; ``verification.registry`` collects them."""
