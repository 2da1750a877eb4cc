"""The solver, in rooms in the order of the work; ``corovec`` hands on its public names.

``model`` (what is computed, as data), ``input`` (model files), ``kernels`` (compiled functions of
arrays), ``system`` (unknowns, matrices, linear solvers), ``dynamics``, ``statics``, ``results``
(files), ``runtime`` (processes, provenance).
"""
