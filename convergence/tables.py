"""Tidy tables of a study: one observation a row, SI units, nothing typed by hand."""

import datetime
import json
from functools import cache

import numpy as np
import pandas as pd

from corovec import drift, total_energy
from corovec.solver.dynamics.result import Drift, unloaded_row
from corovec.solver.results.files import replacing
from corovec.solver.runtime.provenance import commit, machine, versions

from .motion import Growth, deviations, displacement, dominant_line, growth, recurrence
from .rates import crossing, finest_as_reference, log_log_fit, mesh_errors, richardson
from .study import (
    DRIFT_TARGET,
    FLIGHT,
    JUSTIFIED,
    RHO_INF,
    halved,
    printed_results,
    unloaded_energy,
)
from .verdicts import PAPERS, verdicts

DRIFTS = {f"{name}_drift": name for name in ("energy", "linear_momentum", "angular_momentum")}

WINDOWS = (0.125, 0.25, 0.5, 1.0)
"""Parts of the free flight over which drifts are shown."""

SYMMETRIC = 0.1
"""Until this time [s] a symmetric motion must stay symmetric."""

INSTANTS = 24
"""Later instants at which the asymmetry is shown."""

MARKS = 5
"""Instants at which the energy of a run with rho_inf is shown, from unloading to the end."""


def study_tables(study, outcomes):
    """``{name: DataFrame}`` of everything a study found."""
    tables = {"mesh": mesh_table(study, outcomes), "time_step": time_step_table(study, outcomes),
              "drift": drift_table(study, outcomes),
              "dissipation": dissipation_table(study, outcomes)}
    if study.motion:
        tables["symmetry"] = symmetry_table(study, outcomes)
        tables["growth"] = growth_table(study, outcomes)
        tables["motion"] = motion_table(study, outcomes)
    tables["summary"] = summary_table(study, tables)
    tables["verdicts"] = pd.DataFrame(
        [{"case": study.case, **row.as_dict()} for row in verdicts(study, tables)])
    tables["runs"] = runs_table(study, outcomes)
    return tables


def keeps_promises(verdicts):
    """Whether all that the scheme promises holds or is explained; what the paper says is aside."""
    promised = verdicts[~verdicts["kind"].isin(PAPERS)]
    return not (promised["verdict"] == "deviates (open)").any()


def mesh_table(study, outcomes):
    """Energy after unloading, mesh by mesh, beside the printed one: errors by both rules.

    ``energy`` is that of the time step ``dt``, the same for all meshes, of which errors and orders
    are made; ``energy_limit`` that of a time step of zero, uncertain by ``limit_uncertainty``,
    which is compared with the printed one.
    """
    level = study.level(outcomes)
    dt = study.mesh_steps[level]
    ended = [outcomes[study.mesh_run(n, dt).key] for n in study.elements]
    energy = study.energies(outcomes, level)
    printed = printed_energies(study)
    ours, theirs = richardson(study.elements, energy), richardson(study.elements, printed)
    limits, smallest = zip(*(study.limit(outcomes, n) for n in study.elements))
    at_zero = np.array([limit.value for limit in limits])
    frame = pd.DataFrame({
        "case": study.case, "elements": study.elements, "dt": dt,
        "end_time": [outcome.run.settings.end_time for outcome in ended], "energy": energy,
        "energy_limit": at_zero, "limit_uncertainty": [limit.uncertainty for limit in limits],
        "limit_order": [limit.order for limit in limits], "smallest_dt": smallest,
        "printed": printed_texts(study, "energy"), "difference": at_zero / printed - 1.0,
        "error": finest_as_reference(study.elements, energy)[0],
        "error_of_printed": finest_as_reference(study.elements, printed)[0],
        "printed_error": printed_texts(study, "error"),
        "change": _changes(energy), "change_of_printed": _changes(printed),
        "order": ours.orders, "order_of_printed": theirs.orders,
        "richardson_error": np.abs(energy / ours.limit - 1.0),
        "richardson_error_of_printed": np.abs(printed / theirs.limit - 1.0),
        "mesh_error": mesh_errors(energy), "time_step_share": study.step_changes(outcomes, level)})
    return frame.join(pd.DataFrame([run_measures(outcome) for outcome in ended]))


def time_step_table(study, outcomes):
    """Energy after unloading on the coarsest mesh against the time step, and the observed order.

    ``error`` is that to the limit of the two smallest steps, for order 2; ``mesh_share`` what
    halving the step changes, relative to the smallest mesh error of the study.  A run that had to
    halve a step has no single one: its change is not told.
    """
    smallest = np.min(mesh_errors(study.energies(outcomes, study.level(outcomes))))
    steps = study.temporal_steps
    ended = [outcomes[study.temporal_run(dt).key] for dt in steps]
    energy = np.array([unloaded_energy(outcome) for outcome in ended])
    unclear = np.array([halved(outcome) for outcome in ended])
    change = np.append(np.where(unclear[:-1] | unclear[1:], np.nan, np.diff(energy)), np.nan)
    limit = energy[-1] + (energy[-1] - energy[-2]) / 3.0
    frame = pd.DataFrame({
        "case": study.case, "elements": study.elements[0], "dt": steps,
        "steps_to_unloading": study.unloaded_at / np.array(steps), "energy": energy,
        "change_by_halving": change / energy,
        "order": _orders(steps, np.abs(change)),
        "mesh_share": np.abs(change) / smallest})
    if study.paper_dt not in steps:
        run = study.paper_run
        frame.loc[len(frame)] = {
            "case": study.case, "elements": study.elements[0], "dt": study.paper_dt,
            "steps_to_unloading": study.unloaded_at / study.paper_dt,
            "energy": unloaded_energy(outcomes[run.key]) if run else np.nan}
    frame["error"] = np.abs(frame["energy"] / limit - 1.0)
    frame["justified"] = frame["mesh_share"] < JUSTIFIED
    frame["paper_dt"] = frame["dt"] == study.paper_dt
    return frame


def drift_table(study, outcomes):
    """Drift of energy and momenta on the coarsest mesh against the time step, in windows of free
    flight from unloading to ``until``, and the observed order of the energy's."""
    ended = [outcomes[study.drift_run(dt).key] for dt in study.drift_steps]
    flight, blocks = study.drift_time - study.unloaded_at, []
    for part in WINDOWS:
        until = study.unloaded_at + part * flight
        frame = pd.DataFrame({"case": study.case, "elements": study.elements[0], "until": until,
                              "dt": study.drift_steps, "tolerance": FLIGHT.tolerance}).join(
                                  pd.DataFrame([drifts(outcome, until) for outcome in ended]))
        frame["order"] = _orders(frame["dt"], frame["energy_drift"])
        blocks.append(frame)
    frame = pd.concat(blocks, ignore_index=True)
    frame["paper_dt"] = frame["dt"] == study.paper_dt
    return frame


def dissipation_table(study, outcomes):
    """Energy after unloading against time for rho_inf = 1, 0.9, 0.5, relative to its start, as far
    as all three are run."""
    rows = []
    for rho in RHO_INF:
        outcome = outcomes[study.drift_run(study.drift_steps[0], rho).key]
        history = outcome.history
        if history is None:
            continue
        first = unloaded_row(history, study.unloaded_at)
        energy = total_energy(history)
        last = np.searchsorted(history["time"], study.damped_time * (1.0 + 1e-9), "right") - 1
        for row in np.linspace(first, last, MARKS).round().astype(int):
            rows.append({"case": study.case, "elements": study.elements[0],
                         "dt": study.drift_steps[0], "rho_inf": rho, "time": history["time"][row],
                         "energy_change": energy[row] / energy[first] - 1.0})
    return pd.DataFrame(rows, columns=["case", "elements", "dt", "rho_inf", "time",
                                       "energy_change"])


def symmetry_table(study, outcomes):
    """Asymmetry about each plane against time and time step: the largest since the instant before,
    over the size of the shell."""
    rows = []
    ends = np.append(SYMMETRIC, np.linspace(SYMMETRIC, study.drift_time, INSTANTS + 1)[1:])
    for dt, axis, time, values in _asymmetries(study, outcomes):
        for begin, end in zip(np.append(-1.0, ends), ends):
            within = (time > begin * (1.0 + 1e-9)) & (time <= end * (1.0 + 1e-9))
            rows.append({"case": study.case, "elements": study.elements[0], "dt": dt,
                         "plane": f"{axis} = 0", "until": end,
                         "asymmetry": values[within].max() if within.any() else np.nan})
    return pd.DataFrame(rows, columns=["case", "elements", "dt", "plane", "until", "asymmetry"])


def growth_table(study, outcomes):
    """How the asymmetry about each plane grows: exponentially, or with a power of time."""
    rows = [{"case": study.case, "elements": study.elements[0], "dt": dt, "plane": f"{axis} = 0",
             **growth(time, values, SYMMETRIC)._asdict()}
            for dt, axis, time, values in _asymmetries(study, outcomes)]
    return pd.DataFrame(rows, columns=["case", "elements", "dt", "plane", *Growth._fields])


def motion_table(study, outcomes):
    """Extreme displacements in free flight and whether they repeat, where the paper plots them."""
    rows = []
    for dt in study.drift_steps:
        outcome = outcomes[study.drift_run(dt).key]
        if outcome.status == "failed":
            continue
        for point, component in study.motion["displacement"].items():
            time, u = displacement(outcome, study.definition.points[point].value, component)
            line, again = dominant_line(time, u), recurrence(time, u)
            rows.append({
                "case": study.case, "elements": study.elements[0], "dt": dt, "point": point,
                "component": component, "until": time[-1], "max": u.max(),
                "time_of_max": time[u.argmax()], "min": u.min(), "time_of_min": time[u.argmin()],
                "period": line.period, "share_of_period": line.share, "lag": again.lag,
                "autocorrelation": again.correlation})
    return pd.DataFrame(rows)


def summary_table(study, tables):
    """The numbers that a study comes down to: ours, those of the printed energies of the same
    meshes, those of all printed meshes, and what the paper prints itself."""
    mesh, windows = tables["mesh"], tables["drift"].groupby("until")
    (until, early), (_, late) = list(windows)[0], list(windows)[-1]
    printed = printed_results(study.case) or {"elements": [np.nan], "energy": [np.nan]}
    everything = [float(text) for text in printed["energy"]]
    sources = {"ours": (study.elements, mesh["energy"]),
               "of_printed": (study.elements, printed_energies(study)),
               "of_all_printed": (printed["elements"], everything)}
    fits = {name: finest_as_reference(*data)[1] for name, data in sources.items()}
    limits = {name: richardson(*data) for name, data in sources.items()}
    rows = [
        {"quantity": "slope, finest mesh as reference", "unit": "",
         **{name: fit.slope for name, fit in fits.items()}, "printed": printed.get("slope", "")},
        {"quantity": "R squared", "unit": "", **{name: fit.r_squared for name, fit in fits.items()},
         "printed": printed.get("r_squared", "")},
        {"quantity": "order, successive differences", "unit": "",
         **{name: value.orders[-1] for name, value in limits.items()}},
        {"quantity": "limit, successive differences", "unit": "J",
         **{name: value.limit for name, value in limits.items()}}]
    steps = tables["time_step"].dropna(subset="change_by_halving")
    at_target, beyond = crossing(late["dt"], late["energy_drift"], DRIFT_TARGET)
    last = late.iloc[-1]
    flight = f"until {last['until']:g} s, dt = {last['dt']:g} s"
    for quantity, value, unit, note in (
            ("time step of the mesh study", mesh["dt"][0], "s", ""),
            ("change by halving it / mesh error", mesh["time_step_share"].max(), "", "at most"),
            ("order of the energy in dt",
             log_log_fit(steps["dt"], steps["change_by_halving"].abs()).slope, "", ""),
            ("energy drift", last["energy_drift"], "", flight),
            ("linear momentum drift", last["linear_momentum_drift"], "", flight),
            ("angular momentum drift", last["angular_momentum_drift"], "", flight),
            ("order of the energy drift in dt",
             log_log_fit(late["dt"], late["energy_drift"]).slope, "", f"until {last['until']:g} s"),
            ("order of the early energy drift",
             log_log_fit(early["dt"], early["energy_drift"]).slope, "", f"until {until:g} s"),
            (f"time step for a drift of {DRIFT_TARGET:.0e}", at_target, "s",
             "extrapolated" if beyond else ""),
            ("convergence tolerance of the drift study", FLIGHT.tolerance, "", ""),
            ("time step of the paper", study.paper_dt, "s", "")):
        rows.append({"quantity": quantity, "unit": unit, "ours": value, "note": note})
    frame = pd.DataFrame(rows).fillna({"printed": "", "note": ""})
    frame.insert(0, "case", study.case)
    return frame


def runs_table(study, outcomes):
    """Every run of the study: what it was, how it ended, how long it took."""
    rows = []
    for outcome in outcomes.values():
        run, s = outcome.run, outcome.run.settings
        if run.case == study.case:
            rows.append({
                "case": run.case, "elements": run.elements, "membrane": run.model.membrane,
                "dt": s.dt, "end_time": s.end_time, "scheme": s.scheme.name,
                "rho_inf": s.scheme.rho_inf,
                "status": outcome.status, "error": outcome.error, **run_measures(outcome),
                "begun_at": outcome.begun_at, "key": run.key})
    return pd.DataFrame(rows).sort_values(["elements", "end_time", "rho_inf", "dt"],
                                          ignore_index=True)


@cache
def run_measures(outcome):
    """What a run says of itself: drifts since unloading, iterations, halvings, solver, seconds."""
    history = outcome.history
    if history is None:
        return {**drifts(outcome), "iterations_per_step": np.nan, "halvings": np.nan,
                "seconds": np.nan}
    return {**drifts(outcome), "iterations_per_step": float(history["iterations"][1:].mean()),
            "halvings": int(history["halvings"].sum()),
            "solver": outcome.description["solver"], "seconds": outcome.seconds}


@cache
def drifts(outcome, until=np.inf):
    """Drift of energy and momenta from unloading to ``until``; NaN for a run that failed, and for
    the momenta of a supported shell."""
    history = outcome.history
    if history is None:
        return dict.fromkeys(DRIFTS, np.nan)
    end = np.searchsorted(history["time"], until * (1.0 + 1e-12), side="right")
    return drifts_of(history[:end], outcome.run.model)


def drifts_of(history, model):
    """As ``drifts``, of a history; NaN where it ends before the loads do."""
    changes = vars(drift(history, model.unloaded_at, bool(model.supports)) or Drift(*[None] * 4))
    return {column: np.nan if changes[name] is None else changes[name]
            for column, name in DRIFTS.items()}


def printed_texts(study, name):
    """Printed strings for the meshes of a study, empty where nothing is printed."""
    printed = printed_results(study.case) or {"elements": [], name: []}
    texts = dict(zip(printed["elements"], printed[name]))
    return [texts.get(n, "") for n in study.elements]


def printed_energies(study):
    """Printed energies for the meshes of a study [J], NaN where nothing is printed."""
    return np.array([float(text or "nan") for text in printed_texts(study, "energy")])


def origin(studies, outcomes):
    """Where numbers come from: commit, versions and machine now, and those that made the files."""
    makers = {json.dumps({name: outcome.description[name] for name in ("versions", "machine")},
                         sort_keys=True) for outcome in outcomes.values() if outcome.description}
    return {"date": datetime.datetime.now().isoformat(timespec="seconds"), "commit": commit(),
            "size": studies[0].size_name, "versions": versions(), "machine": machine(),
            "computed_with": [json.loads(text) for text in sorted(makers)]}


def write_tables(folder, tables, origin):
    """One CSV a table, and all of them with their origin in ``study.json``; each replaced as a
    whole."""
    for name, frame in tables.items():
        with replacing(folder / f"{name}.csv") as partial:
            frame.to_csv(partial, index=False)
    with replacing(folder / "study.json") as partial:
        partial.write_text(json.dumps(as_json(tables, origin), indent=1), encoding="utf-8")


def as_json(tables, origin):
    """Tables and their origin as one object of plain values, all digits kept; NaN becomes None."""
    records = {name: [{key: value if value == value else None for key, value in row.items()}
                      for row in frame.to_dict("records")] for name, frame in tables.items()}
    return {"origin": origin, **records}


def _asymmetries(study, outcomes):
    """(dt, axis, times, asymmetry) of the drift study's runs and the planes of symmetry."""
    for dt in study.drift_steps:
        outcome = outcomes[study.drift_run(dt).key]
        if outcome.status != "failed":
            for axis in study.motion["symmetry"]:
                yield dt, axis, *deviations(outcome, "xyz".index(axis))


def _orders(steps, values):
    """Observed orders between neighbouring time steps (n,), NaN for the first."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.append(np.nan, np.diff(np.log(values)) / np.diff(np.log(steps)))


def _changes(values):
    """Differences to the next coarser mesh (n,), NaN for the coarsest."""
    return np.append(np.nan, np.diff(values))
