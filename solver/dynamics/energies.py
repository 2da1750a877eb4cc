"""Energies of a run by what has them: the shell, bodies, joints, springs, loads and supports."""

from typing import Annotated

import numpy as np

from ..checks import shown
from ..errors import InputError
from ..model.attached import GroundSpring, Spring
from ..model.joints import Turning, names_of
from ..results.layout import ITEMS, items_of
from ..signatures import checked

MOST_SPRINGS = 50
"""Springs between nodes of which each has an energy of its own in results; of more their sum."""

COLUMNS = ("kinetic", "stored", "dissipated", "work")
"""Of the table: kinetic energy, what is stored, what damping took since t = 0, and the work that
was done since then [J]."""


def acts(joint):
    """Whether a joint has a moment, or is driven."""
    return isinstance(joint, Turning) and bool(joint.places)


class Energies:
    """What the history of a run keeps of the single items of a model, see ``ITEMS``.

    Attributes:
        names: ``{kind: names of the items}``, those kinds that there are.
        counts: ``(kind, number)`` of each.
    """

    def __init__(self, model):
        joints = [name for name, joint in zip(names_of(model.joints), model.joints)
                  if acts(joint)]
        axial = sum(isinstance(item, Spring) for item in model.attached)
        grounded = any(isinstance(item, GroundSpring) for item in model.attached)
        self._single = axial <= MOST_SPRINGS
        springs = [f"spring {k}" for k in range(axial)] if self._single else ["springs"]
        named = {"joints": joints, "bodies": [body.name for body in model.bodies],
                 "springs": springs + ["springs to the ground"] * grounded}
        self.names = {kind: names for kind, names in named.items() if names}
        self.counts = tuple((kind, len(names)) for kind, names in self.names.items())

    def write(self, rows, system, state, place, record):
        """The last of ``rows``; before it stands that of the step before, if there is one.
        ``record``: ``StepRecord``, of the step between them."""
        row = rows[-1]
        if "joints" in self.names:
            row["joints.stored"] = system.turnings.energies(state)
            if len(rows) == 2:
                done = record.turned[system.turnings.numbers].T
                row["joints.work"], row["joints.lost"] = (
                    rows[0][f"joints.{what}"] + part for what, part in zip(("work", "lost"), done))
        if "bodies" in self.names:
            row["bodies.kinetic"] = system.bodies.kinetic(state, place.start)
        if "springs" in self.names:
            row["springs.stored"] = system.energies_of_springs(state, place, self._single)
            if len(rows) == 2:
                single = record.sprung if self._single else [np.sum(record.sprung)]
                row["springs.lost"] = rows[0]["springs.lost"]
                row["springs.lost"][:len(single)] += single


def run_of(name, run):
    """The history of a run in time, and ``{kind: names}`` of its items."""
    if isinstance(run, dict):
        history, names = run.get("history"), run.get("description", {}).get("energies", {})
    else:
        history, names = getattr(run, "history", None), getattr(run, "items", None)
    if "kinetic_energy" not in (getattr(history, "dtype", np.dtype("f8")).names or ()):
        raise InputError(f"{name} must be a Result, or what read returns of a run in time, is "
                         f"{shown(run)}")
    return history, names or {}


@checked
def energy_table(run: Annotated[tuple, run_of], row: int = None):
    """Energies of a run by item: the shell, each rigid body, joint and spring, loads and supports.

    At any instant the sum of ``kinetic + stored + dissipated - work`` over all items is that of
    t = 0, but for what the scheme adds or loses, see ``energy_balance``.  What a joint has stored
    is in its spring, stops and latch; it dissipates in its dampers, as springs do, and its work is
    that of its motor, its servo or its drive.  The ``shell`` has the kinetic energy of point
    masses, and dissipates by ``Damping`` and the ``dissipation`` of the scheme.  Of more than 50
    springs between nodes, and of springs to the ground, there is the sum.

    Args:
        run: ``Result``, or what ``read`` returns of a run in time.
        row: number of a row of the history alone, -1 of the last; left out, all of them.

    Returns:
        ``pandas.DataFrame`` with the columns time [s], item, kind (shell, body, joint, spring,
        loads, supports), kinetic, stored, dissipated, work [J]; an item a row, instant after
        instant.

    Raises:
        InputError: no run in time, or no such row.
    """
    history, names = run
    if row is not None:
        if not -len(history) <= row < len(history):
            raise InputError(f"row must lie in [{-len(history)}, {len(history) - 1}], is {row}")
        history = history[[row]]
    return table_of(history, names)


def table_of(history, names):
    """``energy_table`` of rows, with the names of the items."""
    from pandas import DataFrame
    kinds = dict(items_of(history.dtype))
    total = {"kinetic": history["kinetic_energy"], "stored": history["strain_energy"],
             "dissipated": history["dissipated"], "work": history["external_work"]}
    booked = {"lost": "dissipated"}
    items, rest = [], {what: values.copy() for what, values in total.items()}
    for kind in ("bodies", "joints", "springs"):
        for k in range(kinds.get(kind, 0)):
            own = {booked.get(what, what): history[f"{kind}.{what}"][:, k] for what in ITEMS[kind]}
            for what, values in own.items():
                rest[what] -= values
            items.append((names[kind][k], SINGLE[kind], own))
    loads = {"work": rest.pop("work")}
    items = [("shell", "shell", rest), *items, ("loads", "loads", loads)]
    if history["support_work"].any():
        items.append(("supports", "supports", {"work": history["support_work"]}))
    n = len(items)
    return DataFrame({
        "time": np.repeat(history["time"], n),
        "item": [item for item, _, _ in items] * len(history),
        "kind": [kind for _, kind, _ in items] * len(history),
        **{what: np.stack([np.broadcast_to(own.get(what, 0.0), len(history))
                           for *_, own in items], axis=1).ravel() for what in COLUMNS}})


SINGLE = {"joints": "joint", "bodies": "body", "springs": "spring"}
"""What one of a kind is called."""
