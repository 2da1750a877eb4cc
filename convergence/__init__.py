"""Mesh-convergence studies of the paper's benchmarks, beside the printed tables."""
