"""Symmetry, extremes and periods of motions given by formulas."""

from types import SimpleNamespace

import numpy as np
import pytest

from corovec.benchmarks import load_case
from corovec.convergence.motion import deviations, displacement, dominant_line, growth, recurrence

SHELL = load_case("hemisphere").model(1024)
A, B = (10.0, 0.0, 0.0), (0.0, 10.0, 0.0)


def moving():
    """u = (x, -y, 0) sin(2 pi t / T) / R, T = 0.04 s, and a node that leaves its symmetric place by
    1e-12 m e^(80 t / s)."""
    t = 3e-3 * np.arange(101)
    u = np.sin(2.0 * np.pi * t / 0.04)[:, None, None] * SHELL.nodes * (0.1, -0.1, 0.0)
    u[:, np.argmax(SHELL.nodes[:, 0] + SHELL.nodes[:, 1]), 2] += 1e-12 * np.exp(80.0 * t)
    return SimpleNamespace(frames=(t, u), run=SimpleNamespace(model=SHELL))


def test_displacement_and_its_period():
    """u_x(A) = sin(2 pi t / 0.04 s) m, thirteen frames a period: to the spline's 5e-4."""
    time, u = displacement(moving(), A, "x")
    assert time[0] == pytest.approx(0.03) and time[-1] == pytest.approx(0.3)
    assert np.abs(u - np.sin(2.0 * np.pi * time / 0.04)).max() < 1e-3
    line, again = dominant_line(time, u), recurrence(time, u)
    assert line.period == pytest.approx(0.04, rel=1e-2) and line.share > 0.99
    assert again.correlation > 0.9999
    assert again.lag / 0.04 == pytest.approx(round(again.lag / 0.04), abs=0.02)
    assert np.allclose(displacement(moving(), B, "y")[1], -u, atol=1e-12)


def test_what_does_not_repeat():
    """Noise and a chirp resemble themselves nowhere; a monotonic displacement does not oscillate.
    """
    time = np.linspace(0.0, 1.0, 1001)
    assert recurrence(time, np.random.default_rng(1).normal(size=1001)).correlation < 0.5
    assert recurrence(time, np.sin(60.0 * time * (1.0 + 2.0 * time))).correlation < 0.8
    assert np.isnan(recurrence(time, time).correlation)


def test_growth_is_that_of_the_formula():
    """Exponential until saturation, then a power of time: the better straight line tells."""
    found = growth(*deviations.__wrapped__(moving(), 0), 0.1)
    assert found.rate == pytest.approx(80.0, rel=1e-3) and found.rate_r_squared > 0.999
    assert found.power_r_squared < 0.99
    assert found.begin == pytest.approx(0.102) and 0.2 < found.end < 0.3
    time = np.linspace(0.0, 2.0, 201)
    found = growth(time, 1e-14 * time**1.5, 0.1)
    assert found.power == pytest.approx(1.5) and found.rate_r_squared < 0.95 < found.power_r_squared
    assert found.end == 2.0
    assert np.isnan(growth(time, np.ones(201), 0.1).rate)
