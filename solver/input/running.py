"""The steps of a model file, run: an equilibrium, a motion, or a motion from an equilibrium."""

import re
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..dynamics.result import Result
from ..dynamics.settings import Settings
from ..dynamics.simulation import check_run, probes_of, simulate
from ..errors import InputError
from ..results.files import output_path
from ..signatures import Count, File, checked
from ..statics.load_control import load_control
from ..statics.result import StaticResult
from ..statics.settings import StaticSettings
from .model_file import ModelFile


class ModelRun(NamedTuple):
    """What the steps of a model file gave.

    Attributes:
        static: ``StaticResult`` of the static step, or None.
        dynamic: ``Result`` of the dynamic step, or None.
    """

    static: StaticResult | None
    dynamic: Result | None


class ReadySteps:
    """The steps of a model file on one of its meshes, checked and ready.

    Attributes:
        definition: ``ModelFile``.
        static: ``Model`` under the loads of the static step, or None.
        dynamic: ``Model`` under those of the dynamic step, or None.
        settings: ``Settings`` of the dynamic step, or None.

    Raises:
        InputError: as of ``run_model``; nothing has been computed.
    """

    def __init__(self, definition, elements=None, settings=None, membrane="stress"):
        static, dynamic = definition.static, definition.dynamic
        if settings is not None and dynamic is None:
            raise InputError("settings are of a motion, the model has a static step only")
        elements = definition.elements if elements is None else elements
        first = dynamic or static
        model = definition.model(elements, loads=first.loads, membrane=membrane)
        self.definition, self.elements = definition, elements
        self.dynamic = model if dynamic else None
        self.static = model if static else None
        if static and dynamic:  # the directors and element constants are those of one model
            mesh = definition.mesh(elements)
            self.static = model.under(definition.loads_on(mesh, names=static.loads, rising=True),
                                      definition.supports_on(mesh, rising=True),
                                      definition.joints_on(elements, rising=True))
        self.settings = settings if settings or not dynamic else dynamic.settings(
            frame_every=definition.output.frame_every, stresses=definition.output.stresses)
        if dynamic:
            try:
                check_run(self.dynamic, self.settings, self._probes)
            except InputError as error:
                raise self._in_file(error) from None

    def run(self, output=None, overwrite=False, resume=False, progress=None, case="",
            threads=1):
        """``ModelRun``; arguments as of ``run_model``."""
        output = output_path(output, overwrite, resume)
        files = {"overwrite": overwrite, "resume": resume}
        static = self._static(output, files) if self.static else None
        if not self.dynamic:
            return ModelRun(static, None)
        return ModelRun(static, simulate(
            self.dynamic, self.settings, output=output, progress=progress, case=case,
            probes=self._probes, start=static and static.states[-1], threads=threads,
            **files))

    @property
    def _probes(self):
        return probes_of("points and probes", self.definition.probes_on(
            self.definition.mesh(self.elements)))

    def _static(self, output, files):
        """The static step."""
        factors = np.linspace(0.0, 1.0, self.definition.static.increments + 1)[1:]
        return load_control(self.static, factors, StaticSettings(
            stresses=self.definition.output.stresses), output=self.static_output(output), **files)

    def static_output(self, output):
        """The file of the static step: where a motion follows, with -static in its name."""
        return output.with_stem(f"{output.stem}-static") if output and self.dynamic else output

    def _in_file(self, error):
        """An error of a load of the model as one of the load in the file."""
        load = re.match(r"load (\d+): ", str(error))
        if not load:
            return error
        number = self.definition.load_number(self.elements, int(load[1]),
                                             self.definition.dynamic.loads)
        return InputError(f"loads[{number}].history: {str(error)[load.end():]}")


@checked
def run_model(definition: ModelFile, elements: Count = None, settings: Settings = None,
              progress: Callable = None, *, output: File = None, overwrite: bool = False,
              resume: bool = False, membrane: str = "stress", threads: Count = 1):
    """Run the steps of a model file, as ``corovec run`` does.

    A motion after a static step starts from its equilibrium, at rest; the points and probes of the
    file are recorded.

    Args:
        definition: ``ModelFile``, of ``read_model``.
        elements: mesh, by its number of elements; by default that of the file.
        settings: ``Settings`` of the motion; by default those of the file.
        progress: as of ``simulate``.
        output: result file (HDF5); that of a static step which a motion follows has ``-static`` in
            its name.
        overwrite: replace ``output`` if it exists.
        resume: continue ``output`` from its last checkpoint if it exists.
        membrane: assumed membrane field, as of ``Model``.
        threads: as of ``simulate``, of the motion.

    Returns:
        ``ModelRun``.

    Raises:
        InputError: no such mesh, settings for a file without a motion, or as of ``load_control``
            and ``simulate``.
        ResultFileError: ``output`` exists, is damaged, foreign, or from other parameters.
        StepError: a step did not converge.
    """
    return ReadySteps(definition, elements, settings, membrane).run(
        output, overwrite, resume, progress, definition.name, threads)
