"""Functions of time: values, ends, what steps miss of them, expressions and tables; weight."""

import pickle
import re

import numpy as np
import pytest
from scipy.integrate import quad

from corovec import (
    Expression,
    Gravity,
    Harmonic,
    InputError,
    NodalLoad,
    Settings,
    Steps,
    Support,
    TimeFunction,
    load_control,
    read_time_function,
    simulate,
)
from corovec.solver.runtime.provenance import fingerprint
from corovec.verification.models import rectangle

JUMPS = Steps((0.1, 0.3), (2.0, -1.0))


@pytest.mark.parametrize("function, formula", [
    (TimeFunction((0.0, 0.5, 1.0), (0.0, 2.0, 0.0)), lambda t: max(0.0, 2.0 - abs(4.0 * t - 2.0))),
    (JUMPS, lambda t: 0.0 if t < 0.1 else 2.0 if t < 0.3 else -1.0),
    (Harmonic(2.0, 3.0, 0.4, 0.5), lambda t: 0.5 + 3.0 * np.sin(4.0 * np.pi * t + 0.4)),
    (Expression("where((t > 0.1) & (t < 0.2), 1, -2 * exp(-t)) + t**2 * cos(pi * t)"),
     lambda t: (1.0 if 0.1 < t < 0.2 else -2.0 * np.exp(-t)) + t**2 * np.cos(np.pi * t)),
    (Expression("3"), lambda t: 3.0)])
def test_values(function, formula):
    """One time and many give the same numbers; a pickled function is equal."""
    times = np.linspace(0.0, 1.2, 61) + 1e-4
    expected = [formula(t) for t in times]
    np.testing.assert_allclose(function(times), expected, rtol=1e-14, atol=1e-14)
    assert [function(t) for t in times] == function(times).tolist()
    assert type(function(0.2)) is float
    assert pickle.loads(pickle.dumps(function)) == function
    drawn = np.interp(times, *function.curve(1.2))
    assert np.median(np.abs(drawn - expected)) < 1e-4 * np.ptp([*expected, 0.0])


def test_ends():
    assert (JUMPS.end, JUMPS.settled) == (np.inf, 0.3)
    assert Steps((0.0, 0.7), (1.0, 0.0)).end == 0.7 == Steps((0.0, 0.7), (1.0, 0.0)).settled
    assert Harmonic(1.0).end == np.inf == Expression("t").settled
    assert JUMPS.integral(0.5) == pytest.approx(quad(JUMPS, 0.0, 0.5, points=(0.1, 0.3))[0])
    assert JUMPS.integral(0.2) == pytest.approx(0.2) and JUMPS.integral(0.05) == 0.0


@pytest.mark.parametrize("text, message", [
    ("__import__('os')", "Function '__import__' not defined"),
    ("t.real", "Attribute is not available"), ("[t, t]", "List is not available"),
    ("lambda: 1", "Lambda is not available"), ("t = 3", "Assign is not available"),
    ("t if t else 1", "IfExp is not available"), ("sin(x=t)", "keyword is not available"),
    ("import os", "Import is not available"), ("f'{t}'", "JoinedStr is not available"),
    ("1; 2", "is more than one"), ("2 *", "invalid syntax"), ("(" * 150, "never closed|too many"),
    ("omega * t", "'omega' is not defined"), ("sin", "something is no number"),
    ("'a'", "something is no number"), ("sin(t, t)", "another number of arguments"),
    ("where(t)", "another number of arguments"), ("0 < t < 1", "something is no number"),
    ("1j", "something is no number"), ("", "must be one line"), (5, "must be one line")])
def test_what_is_no_arithmetic(text, message):
    """Nothing is executed; one line names the text."""
    with pytest.raises(InputError, match=message) as found:
        Expression(text)
    assert "\n" not in str(found.value)


def test_powers_end_at_infinity():
    """No integer of any size is ever made."""
    assert Expression("9**9**9**9")(0.0) == np.inf


@pytest.mark.parametrize("function, message", [
    (Harmonic(50.0), r"dt 0.01 s is too long for its time function: the steps miss 0\.01"),
    (Expression("sin(2 * pi * 60 * t)"), "dt 0.01 s is too long for its time function"),
    (Expression("1 / (t - 0.015)"), "its time function is inf at t = 0.015 s"),
    (Expression("sqrt(t - 0.01)"), "its time function is nan at t = 0.005 s")])
def test_steps_must_see_the_function(function, message):
    """Six steps a period are enough, two are not; what is no number is refused before the run."""
    plate = rectangle(2.0, 1.0, (2, 1), loads=[NodalLoad(2, (0.0, 0.0, 1.0), function)])
    with pytest.raises(InputError, match=f"load 0: {message}"):
        simulate(plate, Settings(dt=0.01, end_time=0.05))
    slow = rectangle(2.0, 1.0, (2, 1), loads=[NodalLoad(2, (0.0, 0.0, 1e-3), Harmonic(16.0))])
    simulate(slow, Settings(dt=0.01, end_time=0.05))


def test_tables(tmp_path):
    """Two columns of a CSV, with a heading or without, also as a spreadsheet writes it."""
    file = tmp_path / "gust.csv"
    file.write_text("\ufefft [s],u,f\n0,9,1\n0.5,9,2.5\n\n1,9,0\n", encoding="utf-8")
    assert read_time_function(file, (0, 2)) == TimeFunction((0.0, 0.5, 1.0), (1.0, 2.5, 0.0))
    file.write_text("0,1\n1,2\n")
    assert read_time_function(file) == TimeFunction((0.0, 1.0), (1.0, 2.0))


@pytest.mark.parametrize("content, message", [
    (b"t,f\n0,1\n1,x\n", r"row 3 has no numbers in columns 0 and 1: \['1', 'x'\]"),
    (b"t,f\n0,1\n2\n", "row 3 has no numbers"), (b"", "holds no numbers"),
    (b"t,f\n", "holds no numbers"), (b"0,1\n0,2\n", "times .* must increase"),
    (b"0,1\n1,nan\n", "must be finite"), (b"\xff\xfe\x00", "cannot be read"),
    (None, "cannot be read: No such file")])
def test_bad_tables(tmp_path, content, message):
    file = tmp_path / "gust.csv"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(InputError, match=f"{re.escape(str(file))}:? .*{message}"):
        read_time_function(file)


def test_free_fall():
    """z = -g t^2/2 of every node of a free warped shell, to rounding; no strain."""
    shell = rectangle(2.0, 1.0, (4, 2), loads=[Gravity((0.0, 0.0, -9.81))])
    result = simulate(shell, Settings(dt=0.01, end_time=1.0))
    np.testing.assert_allclose(result.displacement, [(0.0, 0.0, -0.5 * 9.81)] * 15, atol=1e-10)
    assert result.history["strain_energy"].max() < 1e-18


def test_weight_is_borne_by_the_supports():
    """The reactions of a plate that lies on its edge are rho g h A."""
    edge = Support((0, 1, 2), ("x", "y", "z", "px", "py", "pz"))
    shell = rectangle(2.0, 1.0, (2, 1), loads=[Gravity((0.0, 0.0, -9.81))], supports=[edge])
    weight = 9.81 * shell.nodal_mass.sum()
    area = shell.thickness[0] * shell.density[0] * 2.0
    assert weight == pytest.approx(9.81 * area, rel=1e-13)
    reaction = load_control(shell, [1e-3]).reactions[-1].sum(axis=0)
    np.testing.assert_allclose(reaction, (0.0, 0.0, 1e-3 * weight), atol=1e-9 * weight)


def test_models_with_other_functions_are_others():
    """The fingerprint by which runs are known tells functions apart."""
    plates = [rectangle(2.0, 1.0, (2, 1), loads=[NodalLoad(2, (0, 0, 1), function)])
              for function in (Harmonic(1.0), Harmonic(2.0), JUMPS, Expression("t"))]
    assert len({fingerprint(plate) for plate in plates}) == 4
