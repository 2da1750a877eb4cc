"""Steps of fourth order in time, composed of five of second order (M. Suzuki, 1990).

    dt = (g + g + (1 - 4 g) + g + g) dt,   g = 1 / (4 - 4^(1/3))

A step of a scheme that is symmetric in time has errors of odd order alone; as ``4 g^3 + (1 - 4 g)^3
= 0``, those of third order cancel.  The part in the middle goes back in time.  What each part
conserves the whole conserves.  Functions of time are taken at the middles of the parts: where they
have a point within a step, the order is that of one part.
"""

from ..errors import InputError
from ..model.attached import Spring
from ..model.joints import Turning
from ..model.nonconservative import Drag
from .newton import StepRecord

OUTER = 1.0 / (4.0 - 4.0**(1.0 / 3.0))

PARTS = (OUTER, OUTER, 1.0 - 4.0 * OUTER, OUTER, OUTER)
"""Lengths of the parts of a step."""


class Composed:
    """Divides the steps of a run into parts of ``PARTS``."""

    def __init__(self, stepper, model):
        """``stepper``: ``Stepper``; ``model``: ``Model``.

        Raises:
            InputError: something takes energy, which the part that goes back would give.
        """
        if name := next(losses(model), None):
            raise InputError(f"order must be 2 where {name} takes energy: 4 goes back in time for "
                             "a part of each step, which would give some")
        self._stepper = stepper

    def advance(self, state, place, time, dt, record):
        """Move ``state`` and its ``place`` from ``time`` to ``time + dt`` [s]; arguments and errors
        of ``Stepper.advance``."""
        record.parts, done = 0, 0.0
        for part in PARTS:
            own = StepRecord()
            self._stepper.advance(state, place, time + done * dt, part * dt, own)
            record.add(own)
            done += part


def losses(model):
    """What of a model takes energy, in words."""
    if model.damping and (model.damping.mass or model.damping.stiffness):
        yield "damping"
    for k, load in enumerate(model.loads):
        if isinstance(load, Drag) and load.coefficient * load.density:
            yield f"load {k}, a drag,"
    for k, item in enumerate(model.attached):
        if isinstance(item, Spring) and (item.damping or item.damper_rates):
            yield f"the damper of attached[{k}]"
    for k, joint in enumerate(model.joints):
        if isinstance(joint, Turning) and (joint.damping or joint.damper_rates
                                           or joint.lock is not None):
            yield f"a damper or a latch of {joint.name or f'joint {k}'}"
