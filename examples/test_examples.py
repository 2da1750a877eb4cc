"""Every example runs, draws its picture, and prints a number that is known from elsewhere."""

import importlib.util
import re
from pathlib import Path

import numpy as np
import pytest

HERE = Path(__file__).parent


def load(name):
    spec = importlib.util.spec_from_file_location(f"example_{name}", HERE / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


pictures = load("pictures")


def numbers(text):
    return [float(number) for number in re.findall(r"-?\d+\.?\d*(?:e[-+]\d+)?", text)]


def free_plate(text):
    """The impulse of the pulse, 200 N * 0.2 s / 2."""
    momentum, drift = numbers(text)[0], numbers(text)[-1]
    assert momentum == pytest.approx(20.0, abs=1e-8)
    assert drift < 1e-4


def roll_up(text):
    """A circle of the strip's length; the mesh of 32 elements is 0.5 % off."""
    gap, diameter = re.search(r"within ([\d.]+) m.*\ndiameter ([\d.]+) m", text).groups()
    assert float(gap) < 0.01 * 12.0
    assert float(diameter) == pytest.approx(12.0 / np.pi, rel=6e-3)


def snap_through(text):
    """Sze, Liu and Lo (2004), tabulated: 0.7421 and 0.1729 of 3000 N; theirs is another mesh."""
    limit, least = (float(re.search(rf"{word} ([\d.]+) N", text)[1])
                    for word in ("limit load", "afterwards"))
    assert limit == pytest.approx(0.7421 * 3000.0, rel=0.02)
    assert least == pytest.approx(0.1729 * 3000.0, rel=0.02)


def t_junction(text):
    """Rigid plates of 2 kg each in closed form, rotary inertia h^2/12 included."""
    mass, h = 2.0, 0.02
    centre, v, w = np.array([0.0, 1.0 / 6.0, 0.5]), np.array([0.5, 0.0, 0.0]), [0.3, 0.0, 2.0]
    angular = np.zeros(3)
    for side, normal in (((-1, 0, 0), (0, 1, 0)), ((1, 0, 0), (0, 1, 0)), ((0, 1, 0), (1, 0, 0))):
        a, b = np.array(side, dtype=float), np.array([0.0, 0.0, 1.0])
        second = mass * ((np.outer(a, a) + np.outer(b, b)) / 3.0
                         + (np.outer(a, b) + np.outer(b, a)) / 4.0
                         + h**2 / 12.0 * np.outer(normal, normal))
        angular += (mass * np.cross((a + b) / 2.0, v - np.cross(w, centre))
                    + np.trace(second) * np.array(w) - second @ w)
    linear, about_origin = (numbers(found) for found in re.findall(r"\[(.*?)\]", text))
    assert linear == pytest.approx([3.0 * mass * 0.5, 0.0, 0.0], abs=1e-8)
    assert about_origin == pytest.approx(angular.tolist(), abs=2e-6)


def variants(text):
    """Periods of Euler and Bernoulli's beam, which knows no shear."""
    rows = np.array([line.split() for line in text.strip().splitlines()[1:]], dtype=float)
    thickness, ours = rows[:, 0], rows[:, 2]
    beam = 2.0 * np.pi / 1.875104**2 * np.sqrt(12.0 * 1000.0 / (1e8 * thickness**2))
    assert ours == pytest.approx(beam, rel=5e-3)


@pytest.mark.parametrize("check", [free_plate, roll_up, snap_through, t_junction, variants],
                         ids=lambda check: check.__name__)
def test_example(check, tmp_path):
    picture = tmp_path / f"{check.__name__}.png"
    check(pictures.run(check.__name__, picture))
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert [path.name for path in tmp_path.iterdir()] == [picture.name]


def test_all_are_checked_and_use_public_names():
    scripts = {path.stem for path in HERE.glob("*.py")} - {"pictures", "test_examples"}
    assert scripts == set(pictures.EXAMPLES)
    for name in scripts:
        source = (HERE / f"{name}.py").read_text(encoding="utf-8")
        modules = set(re.findall(r"(?:from|import) (corovec[\w.]*)", source))
        assert modules <= {"corovec", "corovec.convergence"}
        assert 15 <= len([line for line in source.splitlines() if line.strip()]) <= 45
