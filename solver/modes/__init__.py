"""Small motions about a state: eigenfrequencies and modes, linear buckling."""
