"""Verdicts of a study: its numbers beside the printed ones, and beside what the scheme promises.

No agreement with printed energies is asked for while the geometry or the loads of a case are
assumed, selected or calibrated: rows say on what they rest.  Nor does that explain a difference,
for it would explain any.  What is asked for is what assumptions do not touch.
"""

import numpy as np

from corovec.verification.case import CHOSEN, FITTED, Row, at_least, small

from .rates import finest_as_reference, log_log_fit, richardson
from .study import DRIFT_TARGET, JUSTIFIED, RHO_INF

SECOND_ORDER = 1.8
"""Least observed order that counts as second order."""

PAPERS = ("published", "statement")
"""Kinds of what the paper says, in numbers and in words."""

WEAK = ("calibrated", "selected", "assumed")
"""Provenances that are not the paper's, the weakest first."""

QUASI = 1e-4
"""Energy drift over a whole flight beyond which a scheme does not count as quasi conserving: a
tenth of a line's width in a figure (seen: 1.1e-5; the trapezoidal rule at the same steps: 20
to 500 times more)."""

NEGLIGIBLE = 1e-4
"""Change of an energy by halving the time step, relative to it, that harms no comparison with four
or five printed digits, however small the mesh errors."""

ROUNDING = 1e-11
"""Linear momentum after up to a million steps, relative to the sum of m |v| (seen: 1e-14)."""

ANGULAR = 1e-8
"""Angular momentum of the consistent mass, relative to the sum of m |x - x_c| |v| (seen: 1e-9 at
the time steps of the quick studies, 3e-6 with the trapezoidal rule)."""

SYMMETRY = 1e-8
"""Asymmetry of a symmetric motion over the size of the shell up to ``tables.SYMMETRIC``."""

TO_THE_EYE = 0.01
"""What the paper says of a figure without a number is taken as true to the eye."""


def verdicts(study, tables):
    """``Row`` s of a study."""
    return [*_printed_energies(study, tables["mesh"]),
            *_printed_rates(study, tables["mesh"], tables["summary"]), *_time_step(study, tables),
            *_conservation(study, tables), *_dissipation(study, tables),
            *(_motion(study, tables) if study.motion else ())]


def assumptions(definition):
    """In words, how many parameters of a case are not from the paper; empty if all are."""
    kinds = [provenance for *_, provenance, _ in definition.provenance()]
    counts = [f"{kinds.count(kind)} {kind}" for kind in reversed(WEAK) if kind in kinds]
    return (f"parameters of the case that the paper's text does not give: {', '.join(counts)}"
            if counts else "")


def rests_on(definition):
    """The weakest provenance among the parameters of a case; empty if all are the paper's."""
    kinds = {provenance for *_, provenance, _ in definition.provenance()}
    return next((kind for kind in WEAK if kind in kinds), "")


def last_digit(text):
    """Half a unit of the last digit of a printed number."""
    return 0.5 * 10.0 ** -len(text.rstrip("%").partition(".")[2])


def _printed_energies(study, mesh):
    """Energies at a time step of zero, and errors, beside those printed for the same meshes."""
    rests, finest = rests_on(study.definition), mesh["elements"].iloc[-1]
    for row in mesh.itertuples():
        if row.printed:
            printed = float(row.printed)
            digit, uncertainty = last_digit(row.printed) / printed, row.limit_uncertainty / printed
            yield Row(f"{row.elements} elements: energy after unloading [J]", row.energy_limit,
                      printed, "published", digit, "half of the last printed digit", digits=True,
                      rests_on=rests, uncertainty=uncertainty,
                      explanation=f"the time steps leave it uncertain by {uncertainty:.1e}",
                      covers=uncertainty + (FITTED if rests in CHOSEN else digit))
            if row.elements != finest:
                yield Row(f"{row.elements} elements: error, {finest} as reference", row.error,
                          row.error_of_printed, "published", 2.0 * digit,
                          "half of the last printed digit of both energies", scale=1.0,
                          rests_on=rests)


def _printed_rates(study, mesh, summary):
    """Rates beside those of the energies printed for the same meshes; and the paper's own
    regression, repeated with its energies."""
    known = mesh[mesh["printed"] != ""]
    digits = _uncertainties(known["elements"].to_numpy(), known["printed"].astype(float),
                            known["printed"].map(last_digit)) if len(known) else {}
    steps = _uncertainties(mesh["elements"].to_numpy(), mesh["energy"], mesh["limit_uncertainty"]
                           + (mesh["energy"] - mesh["energy_limit"]).abs())
    for row in summary.itertuples():
        if np.isfinite(row.ours) and np.isfinite(row.of_printed):
            scale = 1.0 if row.unit == "" else None
            size = scale or abs(row.of_printed)
            tolerance, uncertainty = digits[row.quantity] / size, steps[row.quantity] / size
            yield Row(row.quantity, row.ours, row.of_printed, "published", tolerance,
                      "half of the last printed digit of every energy", scale=scale,
                      rests_on=rests_on(study.definition), uncertainty=uncertainty,
                      explanation=f"the time steps leave it uncertain by {uncertainty:.1e}",
                      covers=tolerance + uncertainty)
        if row.printed:
            yield Row(f"printed energies: {row.quantity}", row.of_all_printed, float(row.printed),
                      "published", last_digit(row.printed), "half of the last printed digit",
                      scale=1.0, digits=True)


def _uncertainties(elements, energies, changes):
    """What changes of each of some energies may change of their rates."""
    energies = np.asarray(energies, dtype=float)

    def quantities(values):
        fit, limit = finest_as_reference(elements, values)[1], richardson(elements, values)
        return np.array([*fit, limit.orders[-1], limit.limit])

    names = ("slope, finest mesh as reference", "R squared", "order, successive differences",
             "limit, successive differences")
    found = [np.abs(quantities(energies + one) - quantities(energies)) for one in np.diag(changes)]
    return dict(zip(names, np.sum(found, axis=0)))


def _time_step(study, tables):
    """Whether the time step is justified and the energy of second order in it."""
    limit, mesh = study.mesh_steps[-1], tables["mesh"]
    at_limit = mesh["dt"].iloc[0] == limit
    worst = mesh.loc[mesh["time_step_share"].fillna(np.inf).idxmax()]
    tolerated = max(1.0, NEGLIGIBLE * worst["energy"] / worst["mesh_error"])
    yield Row("halving the time step: change of energy / mesh error, at most",
              worst["time_step_share"], 0.0, "converged", JUSTIFIED,
              "a small part of the mesh error", scale=1.0, covers=tolerated, explanation=(
                  f"{limit:g} s is the smallest time step of size {study.size_name}; less than the "
                  f"mesh error, or than {NEGLIGIBLE:.0e} of the energy, all the same")
              if at_limit else "")
    steps = tables["time_step"].dropna(subset="change_by_halving")
    if len(steps) > 2:
        yield Row("energy against dt: order",
                  log_log_fit(steps["dt"], steps["change_by_halving"].abs()).slope, SECOND_ORDER,
                  "analytic", 0.0, "second order", scale=1.0, above=True,
                  covers=SECOND_ORDER - 1.5, explanation="the largest steps, 50 and 100 until "
                  "unloading, are there to show where the second order begins")


def _conservation(study, tables):
    """Drifts over the whole free flight at the smallest time step, the energy's order, and the time
    step at which it would reach the target."""
    drift = tables["drift"]
    drift = drift[drift["until"] == drift["until"].max()]
    last = drift.iloc[-1]
    when = f"{study.drift_time:g} s, dt = {last['dt']:g} s"
    reason = "second order in dt: reached by a small enough time step"
    yield Row(f"energy drift, {when}", last["energy_drift"], 0.0, "analytic", DRIFT_TARGET, reason,
              scale=1.0, explanation="the size has no time step small enough", covers=QUASI)
    if not study.supported:
        yield small(f"linear momentum drift, {when}", last["linear_momentum_drift"], ROUNDING,
                    "rounding")
        yield small(f"angular momentum drift, {when}", last["angular_momentum_drift"], ANGULAR,
                    reason)
    if len(drift) > 2:
        early = tables["drift"][tables["drift"]["until"] == tables["drift"]["until"].min()]
        yield at_least(f"energy drift until {early['until'].iloc[0]:g} s against dt: order",
                       log_log_fit(early["dt"], early["energy_drift"]).slope, SECOND_ORDER,
                       "second order", "analytic")
        yield Row(f"energy drift until {last['until']:g} s against dt: order",
                  log_log_fit(drift["dt"], drift["energy_drift"]).slope, SECOND_ORDER, "analytic",
                  0.0, "second order", scale=1.0, above=True, covers=SECOND_ORDER - 1.0,
                  explanation="in long flights oscillations that no time step here resolves come "
                  "to the drift, which do not fall with it: at least first order")
        summary = tables["summary"].set_index("quantity")["ours"]
        yield Row(f"time step for an energy drift of {DRIFT_TARGET:.0e} [s]",
                  summary[f"time step for a drift of {DRIFT_TARGET:.0e}"], study.paper_dt,
                  "statement", 0.0, "the paper's time step, which is to be enough", above=True,
                  rests_on=rests_on(study.definition),
                  explanation="second order in dt: the paper's time step leaves more, by that "
                  f"order not more than {QUASI:.0e}", covers=1.0 - np.sqrt(DRIFT_TARGET / QUASI))


def _motion(study, tables):
    """Symmetry, and what the paper says of the displacements it plots."""
    symmetry, motion = tables["symmetry"], tables["motion"]
    early = symmetry[symmetry["until"] == symmetry["until"].min()]
    for plane, asymmetry in early.groupby("plane")["asymmetry"]:
        yield small(f"asymmetry about {plane} up to {early['until'].iloc[0]:g} s, over the radius",
                    asymmetry.max(skipna=False), SYMMETRY, "rounding, grown by the motion")
    if len(motion):
        yield from _claims(study, motion[motion["dt"] == motion["dt"].min()])


def _claims(study, motion):
    """The displacements that a figure plots have equal extremes and are periodic."""
    figure, rests = study.motion["figure"], rests_on(study.definition)
    first, *others = motion.itertuples()
    largest = motion[["max", "min"]].abs().max(axis=None)
    for row in others:
        for extreme in ("max", "min"):
            yield Row(f"{figure}: {extreme} {_name(first)} = {extreme} {_name(row)} [m]",
                      getattr(first, extreme), getattr(row, extreme), "statement", TO_THE_EYE,
                      "identical, to the eye", scale=largest, rests_on=rests)
    for row in motion.itertuples():
        yield Row(f"{figure}: {_name(row)} correlated with itself {row.lag:.4g} s later",
                  row.autocorrelation, 1.0, "statement", TO_THE_EYE, "periodic, to the eye",
                  rests_on=rests)


def _name(row):
    """A displacement of the motion table."""
    return f"u_{row.component}({row.point})"


def _dissipation(study, tables):
    """The smaller rho_inf, the more energy is lost, as far as the energy of the conserving scheme
    stands still at the same time step."""
    change = tables["dissipation"].groupby("rho_inf")["energy_change"].last().reindex(RHO_INF)
    drift = tables["drift"]
    drift = drift.loc[(drift["dt"] == study.drift_steps[0])
                      & (drift["until"] <= study.damped_time * (1.0 + 1e-9)), "energy_drift"].max()
    for above, below in zip(RHO_INF[:-1], RHO_INF[1:]):
        yield Row(f"energy change with rho_inf = {above:g} + drift - change with {below:g}",
                  change[above] + drift - change[below], 0.0, "analytic", 0.0,
                  "a smaller rho_inf dissipates more", scale=1.0, above=True, covers=QUASI,
                  explanation="what the step resolves is hardly damped, and its energy changes by "
                  "second order in dt, either way")
