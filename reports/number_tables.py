"""Markdown of the tables that ``corovec numbers`` writes, each a function of the snapshot."""

CASES = ("l-plate", "ruler", "hemisphere", "plates")
METHODS = {"skyline": "skyline LDLᵀ", "dense": "dense Gauss", "auto": "production",
           "lapack-lu": "LAPACK dense LU", "banded-lu": "banded LU",
           "banded-cholesky": "banded Cholesky"}
SCHEMES = {"paper": "quasi, global axes", "quasi": "quasi", "exact": "exact",
           "dissipating": "exact, dissipation 0.1", "trapezoidal": "trapezoidal",
           "generalized-alpha": "generalized-α, ρ∞ = 0.8", "fourth-order": "exact, order 4"}
DRIFTS = ("energy_drift", "linear_momentum_drift", "angular_momentum_drift")
PROGRAMS = ("corovec quasi", "corovec production", "Kratos Bossak", "Kratos Newmark",
            "CalculiX HHT", "CalculiX trapezoidal")


def energies(snapshot):
    """All cases and meshes: energies, orders, drifts."""
    rows = []
    for case in CASES:
        study = snapshot["convergence"][case]
        mesh, drift = study["mesh"], study["drift"]
        rows.append((
            f"{case} " + ", ".join(str(row["elements"]) for row in mesh),
            ", ".join(row["printed"] for row in mesh),
            ", ".join(f"{row['energy']:.{2 if row['energy'] > 1000.0 else 3}f}" for row in mesh),
            f"{mesh[-1]['order_of_printed']:.3g}, {mesh[-1]['order']:.3g}",
            f"{drift['until']:g}, {number(drift['dt'], '.2e')}",
            number(drift["energy_drift"], ".1e"),
            *(number(drift[f"{name}_momentum_drift"], ".1e") for name in ("linear", "angular"))))
    return _table("case, elements | printed [J] | ours [J] | p printed, ours | until, dt [s] "
                  "| E drift | L drift | J drift", rows, _all_measured(snapshot["convergence"]))


def dissipation(snapshot):
    """All cases: order of the drift in a whole flight, and the energy that rho_inf < 1 changes."""
    rows = []
    for case in CASES:
        study = snapshot["convergence"][case]
        change = {row["rho_inf"]: row["energy_change"] for row in study["dissipation"]}
        rows.append((
            case, number(study["summary"].get("order of the energy drift in dt"), ".1f"),
            number(study["summary"].get("time step for a drift of 1e-06"), ".1e"),
            number(max((row["dt"] for row in study["dissipation"]), default=None), ".1e"),
            *(number(change.get(rho), "+.1e") for rho in (0.9, 0.5))))
    return _table("case | order of the drift in dt | dt for a drift of 1e-6 [s] | dt with ρ∞ < 1 "
                  "[s] | energy change, ρ∞ = 0.9 | ρ∞ = 0.5", rows)


def motion(snapshot):
    """The hemisphere's displacements since unloading, and how far it leaves its symmetry."""
    study = snapshot["convergence"]["hemisphere"]
    rows = [(f"u_{row['component']}({row['point']})", number(row["min"], ".3f"),
             number(row["max"], ".3f"), number(row["period"], ".3g"),
             number(row["autocorrelation"], ".5f")) for row in study["motion"]]
    first, last = study["symmetry"]
    return _table("until {until:g} s, dt = {dt:g} s | least [m] | largest [m] | period [s] | "
                  "correlation with itself".format(**study["motion"][0]), rows,
                  "Largest distance from the symmetry planes, over R: "
                  f"{number(first['asymmetry'], '.1e')} at {first['until']:g} s, "
                  f"{number(last['asymmetry'], '.1e')} at {last['until']:g} s; it grows like "
                  f"t^{study['growth'][0]['power']:.2g}.")


def schemes(snapshot):
    """The largest step that each scheme holds, what it keeps there, and its cost beside quasi's."""
    part, rows = snapshot["conservation"], []
    found = _rows_of(part, "schemes", lambda row: CASES.index(row["case"]))
    quasi = {row["case"]: row["cpu_per_second"] for row in found if row["scheme"] == "quasi"}
    for row in found:
        seconds, unit = row["cpu_per_second"], quasi.get(row["case"])
        rows.append((
            f"{row['case']}, {SCHEMES[row['scheme']]}",
            number(row["largest_step"], ".4g") + (" or more" if row["larger_untried"] else ""),
            number(row["of_paper"], ".4g"),
            *(number(row[name], ".1e") for name in DRIFTS),
            number(row["iterations_per_step"], ".1f"),
            number(seconds / unit if seconds and unit else None, ".2f")))
    return _table("case, scheme | largest step held [s] | of the paper's | E drift | L drift "
                  "| J drift | iterations a step | CPU time, quasi = 1", rows,
                  _of_runs(part, "schemes", "case"))


def paths(snapshot):
    """Errors of the path at the same steps, scheme by scheme."""
    part, rows = snapshot["conservation"], []
    flights = [row for row in _rows_of(part, "flights", lambda row: CASES.index(row["case"]))
               if row["path_error"] is not None]
    flown = {row["scheme"] for row in flights}
    compared = {name: title for name, title in SCHEMES.items() if name in flown}
    for case, dt in dict.fromkeys((row["case"], row["dt"]) for row in flights):
        of = {row["scheme"]: row["path_error"] for row in flights
              if (row["case"], row["dt"]) == (case, dt)}
        rows.append((f"{case}, {dt:g}", *(number(of.get(name), ".1e") for name in compared)))
    return _table(f"case, dt [s] | {' | '.join(compared.values())}", rows,
                  _of_runs(part, "flights", "case"))


def times(snapshot):
    """Table 2: CPU seconds of 100 steps, and the ratio of the paper's two solvers."""
    table, rows = snapshot["timing"]["table-2"], []
    for ratio in table["ratios"]:
        of = {row["method"]: row for row in table["times"] if row["elements"] == ratio["elements"]}
        star = "" if of["dense"]["basis"] == "steps" else "*"
        rows.append((str(ratio["elements"]),
                     *(_three(of[name]["unit_cpu"]) + (star if name == "dense" else "")
                       for name in METHODS),
                     _three(ratio["dense_skyline"]) + star, _three(ratio["paper"])))
    return _table(f"elements | {' | '.join(METHODS.values())} | dense/skyline | paper's", rows,
                  "(*) Composed of single calls. " + _measured(table))


def ratios(snapshot):
    """Dense over skyline on the finest mesh of each of the paper's tables."""
    rows = []
    for name in ("table-2", "table-4", "table-6", "table-8"):
        table = snapshot["timing"][name]
        row = [row for row in table["ratios"] if row["dense_skyline"] is not None][-1]
        rows.append((f"{row['case']}, {row['elements']}", f"{row['dense_skyline']:.0f}",
                     row["dense_basis"], number(row["paper"], ".4g"), _commit(table)))
    return _table("case, elements | ours | from | paper | measured at", rows)


def iterations(snapshot):
    """Iterations by the paper's rule and to convergence, by matrix and time step."""
    table = snapshot["timing"]["iterations"]
    steps = dict.fromkeys(row["dt"] for row in table["iterations"])
    found = {(row["matrix"], row["dt"]): f"{row['iterations']}, {row['iterations_converged']}"
             for row in table["iterations"]}
    rows = [(name, *(found[name, dt] for dt in steps))
            for name in dict.fromkeys(row["matrix"] for row in table["iterations"])]
    return _table("dt | " + " | ".join(number(dt, ".0e") for dt in steps), rows, _measured(table))


def exponents(snapshot):
    """Growth of time and memory with the number of unknowns."""
    table = snapshot["timing"]["growth"]
    names = ("assembly", "factorization", "solve", "step", "memory_bytes")
    rows = [(f"{row['case']}, {METHODS[row['method']]} ({row['solvers']})",
             *(number(row[name], ".2f") for name in names)) for row in table["exponents"]]
    return _table("case, method (solvers) | assembly | factorization | solution | step | memory",
                  rows, _measured(table))


def shapes(snapshot):
    """Steps of models that are no benchmarks, by their unknowns."""
    table = snapshot["timing"]["growth"]
    rows = [(f"{row['case']}, {row['unknowns']}", row["solver"],
             *(_three(row[name]) for name in ("first_step", "step")),
             number(row["iterations_per_step"], ".1f"),
             *(_three(row[name]) for name in ("solve", "assembly", "factorization")),
             number(row["peak_memory"], ".0f")) for row in table["shapes"]]
    return _table("shape, unknowns | solver | first step | step | iterations | solution | forces "
                  "and matrix | factorization | MB", rows, _measured(table))


def targets(snapshot):
    """What must be reached, beside what is."""
    table = snapshot["timing"]["targets"]
    measured = any(row["value"] is not None for row in table["targets"])
    return _table("what | unit | target | goal | ours | met", [
        (row["name"], row["unit"], f"{row['target']:g}", f"{row['goal']:g}",
         number(row["value"], ".3g"), row["met"]) for row in table["targets"]],
        _measured(table) if measured else "")


def peers(snapshot):
    """CPU ms a step and energy drift, or where a run ended, by mesh, time step and program."""
    found = _rows_of(snapshot["peers"], "rows", lambda row: (row["elements"], row["dt"]))
    keys = dict.fromkeys((row["elements"], row["dt"], row["end_time"]) for row in found)
    rows = []
    for elements, dt, end in keys:
        of = {row["program"]: row for row in found
              if (row["elements"], row["dt"], row["end_time"]) == (elements, dt, end)}
        rows.append((f"{elements}, {dt:g}, {end:g}", *(_peer(of.get(name)) for name in PROGRAMS)))
    versions = dict.fromkeys(f"{row['program'].split()[0]} {row['version']}"
                             for row in found if row["version"])
    return _table(f"elements, dt, until [s] | {' | '.join(PROGRAMS)}", rows,
                  f"{', '.join(versions)}. {_of_runs(snapshot['peers'], 'rows', 'elements')}")


def peer_ratios(snapshot):
    """How many times faster than the fastest other code, against the size of the mesh."""
    found = _rows_of(snapshot["peers"], "speedups", lambda row: (row["elements"], row["dt"]))
    return _table("elements, dt | fastest other code | its CPU time over that of production", [
        (f"{row['elements']}, {row['dt']:g}", row["fastest"], f"{row['factor']:.2g}")
        for row in found], _of_runs(snapshot["peers"], "speedups", "elements"))


def command(entry):
    """Lines that a command without a result file gave, and that command; with ``commit`` unless the
    lines name theirs."""
    at = f"; {_commit(entry)}" if "commit" in entry else ""
    return "\n".join([*entry["lines"], "", f"By `{entry['command']}`{at}."])


def number(value, form):
    """``value`` as text, – for None."""
    return "–" if value is None else _short(format(value, form))


def _three(value):
    """Three digits, never as a power of ten."""
    return f"{float(f'{value:.3g}'):g}"


def _short(text):
    """``2.70e-07`` as ``2.7e-7``."""
    mantissa, e, exponent = text.partition("e")
    if not e:
        return text
    mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
    return f"{mantissa}e{int(exponent)}"


def _peer(row):
    if row is None or row["cpu_ms_per_step"] is None:
        return "–"
    ended = "" if row["survived"] else f"ended at {row['reached']:.2g} s"
    drift = "" if row["energy_drift"] is None else number(row["energy_drift"], ".1e")
    return ", ".join(filter(None, (_three(row["cpu_ms_per_step"]), ended or drift)))


def _table(head, rows, note=""):
    lines = [f"| {head} |", "|---" * (head.count("|") + 1) + "|",
             *(f"| {' | '.join(row)} |" for row in rows)]
    return "\n".join([*lines, "", note] if note else lines)


def _all_measured(parts):
    """Where and when several parts were measured, those together that were so together."""
    names = {}
    for case in CASES:
        names.setdefault(_measured(parts[case]).rstrip("."), []).append(case)
    if len(names) == 1:
        return f"{next(iter(names))}."
    return "; ".join(f"{text} ({', '.join(cases)})" for text, cases in names.items()) + "."


def _rows_of(part, table, key):
    """Rows of a table of all runs of a part, in the order of a key."""
    return sorted((row for run in part["runs"] for row in run[table]), key=key)


def _of_runs(part, table, column):
    """Where and when the runs of a part were measured, with the values of a column of each."""
    found = []
    for run in part["runs"]:
        own = dict.fromkeys(str(row[column]) for row in run[table])
        if own:
            found.append(f"{_where(run)} ({', '.join(own)})")
    return f"Measured at {'; '.join(found)}."


def _measured(part):
    return f"Measured at {_where(part)}."


def _where(part):
    return f"{_commit(part)}, {part['machine']}"


def _commit(part):
    return f"commit {part['commit'][:7]}" if part["commit"] else "a commit not recorded"
