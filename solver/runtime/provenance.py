"""What a result depends on: model, settings, versions of libraries, machine."""

import hashlib
import json
import os
import platform
import subprocess
from dataclasses import asdict
from importlib import metadata
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname

import numpy as np


def describe(model, settings, solver, case=None, probes=None, start=None, energies=None, **plan):
    """What a result file says of its run; a resumed run must agree but for versions and machine.

    ``probes``: nodes by name, of a run in time; ``start``: arrays of the configuration that it
    starts from, if that is not the model's; ``energies``: names of the items whose energies are
    kept, by kind; ``plan``: what a static run is asked for, beside its settings.
    """
    own = {} if probes is None else {"probes": probes, "start": digest(start),
                                     "energies": energies or {}}
    return {"case": case, "fingerprint": fingerprint(model),
            "settings": {**plan, **asdict(settings)}, "nodes": len(model.nodes),
            "elements": len(model.quads), "edges": model.folds._asdict(),
            "body": body(model), **model.mechanism, **own,
            "membrane": model.membrane, "shear": model.shear,
            "solver": solver, "unloaded_at": model.unloaded_at, "supported": model.grounded,
            "versions": versions(), "machine": machine()}


def body(model):
    """Mass properties of a model, as plain numbers."""
    return {name: np.asarray(value).tolist()
            for name, value in model.mass_properties._asdict().items()}


def fingerprint(model):
    """SHA-256 of everything that defines a model."""
    digest = hashlib.sha256()
    for array in (model.nodes, model.quads, model.thickness, model.youngs, model.poisson,
                  model.density, model.normals, model.directors.first,
                  model.directors.vertices, model.velocity, model.normal_velocity):
        digest.update(np.ascontiguousarray(array).tobytes())
    digest.update(repr((model.loads, model.supports, model.attached, model.damping, model.cyclic,
                        model.membrane, model.shear, *model.sections, *model.joints,
                        *model.bodies)).encode())
    return digest.hexdigest()


def digest(arrays):
    """SHA-256 of some arrays, None for none."""
    return None if arrays is None else hashlib.sha256(
        b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)).hexdigest()


def versions():
    """Versions that a result depends on."""
    names = ("corovec", "numpy", "scipy", "numba", "h5py")
    return {"python": platform.python_version(), **{name: metadata.version(name) for name in names}}


def machine():
    """Processor and operating system."""
    model = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo") as info:
            model = next(line.split(":", 1)[1].strip() for line in info if "model name" in line)
    except (OSError, StopIteration):
        pass
    return {"processor": model, "system": f"{platform.system()} {platform.machine()}"}


def usable_cores():
    """Processor cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def commit():
    """Commit of the sources, marked if they were edited; the package's version outside git.

    Of sources that were installed from a folder, that folder's commit if they are still the same.
    """
    folder = _installed_from(Path(__file__).parents[1])
    try:
        subprocess.run(["git", "ls-files", "--error-unmatch", "__init__.py"], cwd=folder,
                       check=True, capture_output=True)
        return subprocess.run(["git", "describe", "--always", "--dirty", "--abbrev=40"], cwd=folder,
                              check=True, capture_output=True, text=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return f"version {metadata.version('corovec')}"


def _installed_from(folder):
    """The folder from which pip copied the package in ``folder``, while both are equal."""
    try:
        url = json.loads(metadata.distribution("corovec").read_text("direct_url.json") or "{}")
        origin = Path(url2pathname(urlsplit(url.get("url", "")).path), folder.name)
        same = all((origin / path.relative_to(folder)).read_bytes() == path.read_bytes()
                   for path in folder.rglob("*") if path.suffix in (".py", ".toml"))
    except (OSError, ValueError, metadata.PackageNotFoundError):
        return folder
    return origin if same else folder
