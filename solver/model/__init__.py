"""The model: mesh, material, loads and supports as data, and the constants of its elements."""
