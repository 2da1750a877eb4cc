"""Runs that several tests draw."""

import pytest

from corovec import Settings, line_load, load_control, simulate
from corovec.benchmarks import load_case
from corovec.reports.recording import Recording
from corovec.verification.shells import strip


@pytest.fixture(scope="session")
def runs(tmp_path_factory):
    """Files of the L-plate on two meshes, loaded until 1 s, 13 frames of 0.1 s each."""
    folder = tmp_path_factory.mktemp("runs")
    paths = []
    for elements in (30, 120):
        paths.append(folder / f"l{elements}.h5")
        simulate(load_case("l-plate").model(elements),
                 Settings(dt=0.02, end_time=1.2, frame_every=5), output=paths[-1], case="l-plate")
    return paths


@pytest.fixture(scope="session")
def recordings(runs):
    return [Recording.open(path) for path in runs]


@pytest.fixture(scope="session")
def static_path(tmp_path_factory):
    """File of a cantilever under an end force, by load control."""
    path = tmp_path_factory.mktemp("static") / "cantilever.h5"
    model, _ = strip(10.0, 16, lambda X, tip: line_load(X, tip, (0.0, 0.0, 4.0)))
    load_control(model, (0.25, 0.5, 1.0), output=path)
    return path
