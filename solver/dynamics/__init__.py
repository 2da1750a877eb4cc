"""Motion in time: schemes, Newton's iteration, steps, runs."""
