"""The paper's tables beside ours, as rows of text for the page: what the suites wrote, worded."""

from dataclasses import dataclass, field

from corovec.convergence.verdicts import PAPERS
from corovec.timing.printed import cells
from corovec.timing.tables import BASES, TABLES
from corovec.verification.case import CHOSEN

VERDICTS = {
    "failed": "ended with an error",
    "deviates (open)": "differs by more than the last printed digit, or the tolerance beside it, "
                       "be it ever so little; why is not known",
    "not run": "belongs to this size, but was not yet run, or not since its sources changed",
    "deviates (explained)": "differs, with the reason given, by no more than the bound beside it",
    "not reproducible": "the paper's data is lost and cannot be made again",
    "drawn": "its curves are lost, so that shapes cannot be compared; beside it what was",
    "calibrated": "agrees, on data fitted to a printed number of its kind: that proves nothing",
    "selected": "agrees, on data chosen among candidates by printed numbers: that proves nothing",
    "within tolerance": "differs by less than a tolerance that carries its reason",
    "better": "nearer to the exact value than the reference",
    "bound met": "beyond a bound, by how much is no matter",
    "match": "equal, to rounding or to the printed digits",
    "left out": "does not belong to this size",
}
"""All verdicts, the worst first, and what they say."""

AGAINST = {"the paper": PAPERS, "other publications and programs": ("recalled", "other code"),
           "closed forms and finer results of our own": ("analytic", "converged"),
           "what wrong or weaker variants must give": ("baseline",)}
"""What rows are compared with, by their kinds."""

METHODS = {"skyline": "skyline LDLᵀ", "dense": "dense Gauss", "auto": "production default",
           "lapack-lu": "LAPACK dense LU", "banded-lu": "LAPACK banded LU",
           "banded-cholesky": "LAPACK banded Cholesky"}

ENERGY = "elements: energy after unloading"
"""What the rows of Tables 1, 3, 5, 7 are called, after the number of elements."""

ROUNDS = ("least", "lower quartile", "median", "upper quartile", "rounds")
"""Heads of the columns that show how the rounds of a timing lie."""

WORDS = frozenset((
    "mesh", "solver", "verdict", "quantity", "note", "basis", "target", "unit", "met", "detail",
    "matrix", "case", "parameter", "value", "provenance", "source", "what", "kind", "reason",
    "phase", "result", "moved", "part", "status", "command", "message", "scheme"))
"""Heads of columns that hold words; the others hold numbers, which stand on the right."""

KNOWN_BY = ("what", "target", "mesh", "parameter", "part", "quantity")
"""Heads of columns by which rows are known."""


@dataclass(frozen=True)
class Cell:
    """A verdict of the page: a row of a table, or a cell of the first screen's grid.

    Attributes:
        label: what is judged.
        verdict: one of ``VERDICTS``.
        topic: what it is about, in few words.
        detail: how many rows have which verdict.
        href: the row that gave the verdict, or the section that shows why there is none.
        beside: what was compared, where the verdict does not say it.
        rests_on: ``selected`` or ``calibrated`` where the verdict does not say it.
    """

    label: str
    verdict: str
    topic: str = ""
    detail: str = ""
    href: str = ""
    beside: str = ""
    rests_on: str = ""

    @property
    def id(self):
        """``Figure 16a`` -> ``figure-16a``."""
        return self.label.lower().replace(" ", "-")

    @property
    def style(self):
        """The verdict as a name for the style sheet."""
        return self.verdict.replace("(", "").replace(")", "").replace(" ", "-")


@dataclass(frozen=True)
class Table:
    """A table of the page: heads, rows of text, notes below.

    Attributes:
        name: caption.
        columns: heads.
        rows: texts, verdicts as ``Cell`` s.
        notes: sentences below.
        ids: anchors of the rows, as far as they have one.
        card: the column by which a row is known where there is no room for its columns, and it
            becomes a paragraph; None if rows are numbers to compare, which then scroll.
    """

    name: str
    columns: tuple
    rows: list
    notes: list = field(default_factory=list)
    ids: list = field(default_factory=list)

    @property
    def card(self):
        heads = [head for head in KNOWN_BY if head in self.columns]
        return heads[0] if heads else None


def worst(verdicts):
    """The worst of some verdicts; ``not run`` without any."""
    known = list(VERDICTS)
    return min(verdicts, key=known.index, default="not run")


def counts(rows):
    """``{verdict: how many}`` of rows (dictionaries), the worst first."""
    verdicts = [row["verdict"] for row in rows]
    return {name: verdicts.count(name) for name in VERDICTS if name in verdicts}


def anchored(rows, place):
    """Rows, each with the anchor by which the page leads to it."""
    return [{**row, "anchor": f"{place}-{k}"} for k, row in enumerate(rows, 1)]


def distinct(rows):
    """Rows without those that say the same again."""
    found = {}
    for row in rows:
        found.setdefault(str({**row, "anchor": ""}), row)
    return list(found.values())


def compared(rows):
    """``{what with: {verdict: how many}}`` of rows."""
    groups = {what: [row for row in rows if row["kind"] in kinds]
              for what, kinds in AGAINST.items()}
    return {what: counts(group) for what, group in groups.items() if group}


def standing(labelled):
    """What became of what the paper says, in four groups of ``(label, names)``: what its figures
    show of energy and momenta, and holds; of its numbers and statements those
    reproduced, those reproduced on data that are not the paper's, and, of all, those not
    reproduced.

    Args:
        labelled: ``(label, rows)`` of the page's tables and figures; a row counts where it is
            first.
    """
    groups, seen = ({}, {}, {}, {}), {id(row) for row in distinct(
        [row for label, rows in labelled for row in rows if row["kind"] in PAPERS
         or row["kind"] == "analytic" and label.startswith("Figure")])}
    for label, rows in labelled:
        for row in rows:
            if id(row) in seen:
                seen.remove(id(row))
                group = (3 if row["verdict"].startswith("deviates") else
                         0 if row["kind"] not in PAPERS else 2 if row.get("rests_on") else 1)
                groups[group].setdefault(label, []).append(row["name"])
    return [list(group.items()) for group in groups]


DRIFTS = ("energy", "linear momentum", "angular momentum")
"""What is conserved, as the rows of its drifts begin."""


def kept(rows, drawn):
    """By how much energy and momenta of a case drift, at most, in words; empty without any.

    Args:
        rows: of its figures and its study.
        drawn: which of ``DRIFTS`` the paper's figures show.
    """
    found = {name: max((row["value"] for row in rows if row["name"].startswith(f"{name} drift,")),
                       default=None) for name in DRIFTS}
    return ", ".join(f"{name} {number(value, 2)}" + (" (in no figure of the paper)"
                                                       if name not in drawn else "")
                     for name, value in found.items() if value is not None)


def apart(rows):
    """How far the energies of a table lie from the printed ones, at most, and what the last printed
    digit is; empty without any."""
    own = [row for row in rows if ENERGY in row["name"]]
    if not own:
        return ""
    most = max(abs(row["difference"]) for row in own)
    digit = max(row["tolerance"] for row in own)
    return (f"up to {percent(most, 2)} apart"
            + (f", more than the last printed digit, {percent(digit, 2)}" if most > digit else
               ", within the last printed digit"))


def ratio_apart(rows):
    """Between which multiples of the paper's the ratios of a table of times lie; empty without
    any."""
    own = [row["value"] / row["reference"] for row in rows]
    ends = " to ".join(dict.fromkeys(f"{end:.2g}" for end in (min(own), max(own)))) if own else ""
    return ends and f"dense / skyline {ends} times the paper's"


def summary(rows):
    """Counts of the verdicts of rows in words."""
    return ", ".join(f"{count} {name}" for name, count in counts(rows).items())


def energies(study, printed):
    """Tables 1, 3, 5, 7: energy after unloading, mesh by mesh.

    Args:
        study: contents of ``study.json``, None if it was not run.
        printed: of ``printed.toml``.
    """
    ours = {row["elements"]: row for row in study["mesh"]} if study else {}
    verdict = {row["name"]: row for row in study["verdicts"]} if study else {}
    finest = max(ours, default=None)
    rows = []
    for k, elements in enumerate(printed["elements"]):
        row = ours.get(elements, {})
        name = f"{elements} {ENERGY} [J]"
        judged = verdict.get(name, {"verdict": "left out" if study else "not run"})
        rows.append([Cell(name, judged["verdict"], href=leading(judged)), printed["mesh"][k],
                     printed["energy"][k], number(row.get("energy_limit"), 7),
                     number(row.get("limit_uncertainty"), 2),
                     percent(row.get("difference"), sign=True), printed["error"][k],
                     percent(row.get("error_of_printed")), percent(row.get("error")),
                     number(row.get("order_of_printed"), 3), number(row.get("order"), 3)])
    notes = ["Ours is extrapolated to a time step of zero where three steps show second order, "
             "uncertain (±) by what that adds; else it is that of the smallest step, uncertain by "
             "what the last halving changed.  Errors of the last two columns of errors take the "
             f"finest mesh run here, {finest} elements, as reference, for both, at dt = "
             f"{number(study['mesh'][0]['dt'], 3)} s.  Orders come from successive differences, "
             "which need no reference."] if study else []
    return Table(f"{printed['table']}: total energy after load removal",
                 ("verdict", "mesh", "printed [J]", "ours [J]", "±", "difference", "printed error",
                  "printed, same meshes", "our error", "order, printed", "order, ours"),
                 rows, notes)


def rates(study):
    """What a convergence study comes down to."""
    rows = [[row["quantity"] + (f" [{row['unit']}]" if row["unit"] else ""),
             *(number(row[name], 6 if row["unit"] == "J" else 4)
               for name in ("ours", "of_printed", "of_all_printed")), row["printed"] or "–",
             row["note"] or ""] for row in study["summary"]]
    return Table("Convergence, time step, conservation",
                 ("quantity", "ours", "printed energies, same meshes", "all printed energies",
                  "printed", "note"), rows)


def times(name, timing):
    """Tables 2, 4, 6, 8: CPU times of each solver.

    Args:
        name: of ``TABLES``.
        timing: contents of ``timing.json``, or None.
    """
    ours = {(row["elements"], row["method"]): row
            for row in timing["tables"][f"{name}-times"]} if timing else {}
    printed = {(c.elements, c.method): c for c in cells() if c.table == TABLES[name]}
    meshes = dict.fromkeys(elements for elements, _ in printed)
    unit_steps = next(iter(printed.values())).unit_steps
    rows, errata = [], {}
    for elements in meshes:
        for method, title in METHODS.items():
            cell, row = printed.get((elements, method)), ours.get((elements, method), {})
            mark = "†" if cell and cell.errata else ""
            if mark:
                errata[cell.errata] = None
            rows.append([str(elements), title, cell.per_unit + mark if cell else "–",
                         *rounds(row, "unit_", "cpu"), cell.run if cell else "–",
                         duration(row.get("run_cpu"), row.get("run_extrapolated")),
                         row.get("basis", "not run")])
    notes = [f"† Erratum: {erratum}." for erratum in errata]
    bases = {row.get("basis") for row in ours.values()}
    notes += [f"{basis}: {BASES[basis]}." for basis in BASES if basis in bases and basis != "steps"]
    notes.append("(*) printed: the paper's mark of an estimate; ours: extrapolated from steps.")
    return Table(f"{TABLES[name]}: CPU seconds of {unit_steps} steps, and of the whole run",
                 ("elements", "solver", "printed", *(f"{head} [s]" for head in ROUNDS[:-1]),
                  ROUNDS[-1], "printed, run", "ours, run", "basis"), rows, notes)


def rounds(row, prefix="", median="value"):
    """How the rounds of a timing lie, as texts below ``ROUNDS``."""
    count = row.get(f"{prefix}rounds")
    return [*(number(row.get(prefix + name), 3) for name in ("min", "q1", median, "q3")),
            str(count) if count else "–"]


def ratios(name, timing, verdicts):
    """The ratio dense/skyline beside the paper's with its verdict, and its factors."""
    rows = timing["tables"][f"{name}-ratios"]
    verdict = {row["name"].split()[0]: row for row in verdicts}
    return Table(
        "Ratios, which machines share better than seconds",
        ("verdict", "mesh", "unknowns", "dense/skyline, paper", "ours", "basis",
         "by operations", "LAPACK LU/skyline", "basis", "sparsity", "symmetry", "profile"),
        [[Cell("", verdict.get(str(row["elements"]), {}).get("verdict", "left out")),
          str(row["elements"]), number(row.get("unknowns"), 6),
          _as_printed(row), number(row.get("dense_skyline"), 3), row.get("dense_basis", "–"),
          number(row.get("operations"), 3), number(row.get("lapack_skyline"), 3),
          row.get("lapack_basis", "–"), number(row.get("sparsity"), 3),
          number(row.get("symmetry"), 3), number(row.get("profile"), 3)] for row in rows],
        [*(f"Explained: {text}." for text in dict.fromkeys(
            row["explanation"] for row in verdicts if row["explanation"])),
         "Sparsity: LAPACK's dense LU against its banded LU (on the basis of the former); "
         "symmetry: LAPACK's banded LU against its banded Cholesky; profile: that against our "
         "skyline; all three of one factorization and solution alone."],
        [verdict.get(str(row["elements"]), {}).get("anchor", "") for row in rows])


def _as_printed(row):
    """The paper's ratio as read, and as printed where that differs."""
    read, printed = number(row["paper"], 3), number(row["paper_as_printed"], 3)
    return read if read == printed else f"{read} (printed: {printed})"


def targets(timing):
    """Targets of speed beside what was reached."""
    D = timing["tables"]["D"][0]
    return Table(
        "Targets of speed", ("met", "target", "unit", "at most", "goal", *ROUNDS, "detail"),
        [[row["met"], row["name"], row["unit"] or "–", number(row["target"], 3),
          number(row["goal"], 3), *rounds(row), row["detail"]]
         for row in timing["tables"]["targets"]],
        [f"D is the time of one LAPACK LU of a full {D['unknowns']} x {D['unknowns']} matrix on "
         f"this machine: {number(D['D_cpu'], 3)} s of CPU time ({D['D_rounds']} rounds, quartiles "
         f"{number(D['D_q1'], 3)} and {number(D['D_q3'], 3)}, least {number(D['D_min'], 3)})."])


def iterations(timing):
    """Newton iterations with three matrices, and what stopping early leaves."""
    return Table(
        "Iterations of a step with the symmetric matrix, with M and F_m delayed only, and with "
        "the Jacobian",
        ("dt [s]", "matrix", "gap to the Jacobian", "iterations to cc ≤ 1e-6 (no least number)",
         "iterations, to 1e-14", "error left, relative"),
        [[number(row["dt"], 3), row["matrix"], number(row["gap"], 2), str(row["iterations"]),
          str(row["iterations_converged"]), number(row["error"], 2)]
         for row in timing["tables"]["iterations"]])


def accumulation(timing):
    """The paper's rule against a tight one over a whole flight."""
    return Table(
        "Runs that stop by the paper's rule, cc ≤ 1e-6, and by cc ≤ 1e-13: what is left adds up",
        ("time [s]", "iterations, paper's rule", "tight", "energy drift, paper's rule",
         "energy drift, tight", "largest distance [m]", "of a flight of [m]"),
        [[number(row["time"], 3), number(row["paper_iterations"], 3),
          number(row["tight_iterations"], 3), number(row["paper_energy_drift"], 3),
          number(row["tight_energy_drift"], 3), number(row["difference"], 2),
          number(row["travelled"], 3)] for row in timing["tables"]["iterations-run"]])


def phases(timing):
    """Times of single calls and of a step against the number of elements."""
    return Table("CPU seconds of single calls, and of a step",
                 ("case", "elements", "solver", "phase", *ROUNDS),
                 [[row["case"], str(row["elements"]), METHODS[row["method"]], row["phase"],
                   *rounds(row, "call_", "cpu")] for row in timing["tables"]["growth-phases"]])


def growth(timing):
    """Fitted exponents of time and memory against unknowns."""
    phases = ("assembly", "factorization", "solve", "step", "matrix_bytes", "memory_bytes")
    rows = [[row["case"], row["method"], row["solvers"],
             *(number(row.get(phase), 3) for phase in phases)]
            for row in timing["tables"]["growth-exponents"]]
    return Table("Growth of CPU time (single calls, and whole steps) and memory with the number of "
                 "unknowns n: exponents of n",
                 ("case", "method", "solver", *(phase.replace("_", " ") for phase in phases)), rows)


def provenance(definition):
    """Where every parameter of a case comes from."""
    rows = [[name, shown(value), unit or "–", Cell(name, kind), source]
            for name, value, unit, kind, source in definition.provenance()]
    return Table("Every parameter, and where it comes from",
                 ("parameter", "value", "unit", "provenance", "source"), rows)


def provenance_counts(definition):
    """``{kind: how many}`` of the parameters of a case."""
    kinds = [kind for *_, kind, _ in definition.provenance()]
    return {kind: kinds.count(kind) for kind in ("printed", "derived", "assumed", *CHOSEN)
            if kind in kinds}


def verdict_rows(name, rows, place=None):
    """Rows of a suite (dictionaries) with their references, tolerances and reasons; those that are
    ``anchored`` at this place are where their anchors are, the others lead there."""
    here = [place and row.get("anchor", "").startswith(f"{place}-") for row in rows]
    return Table(name, ("verdict", "what", "ours", "reference", "kind", "difference", "tolerance",
                        "reason"),
                 [[Cell("", row["verdict"], href="" if own else leading(row)), row["name"],
                   valued(row), ("≥ " if row.get("above") else "") + f"{row['reference']:.6g}",
                   row["kind"], difference(row), amount(row, row["tolerance"]), reason(row)]
                  for row, own in zip(rows, here)], [],
                 [row["anchor"] if own else "" for row, own in zip(rows, here)])


def leading(row):
    """Where the anchor of a row is; empty without."""
    return f"#{row['anchor']}" if row.get("anchor") else ""


def valued(row):
    """The value of a row, with its uncertainty if it has one."""
    uncertainty = row.get("uncertainty")
    scale = row.get("scale") or abs(row["reference"]) or 1.0
    beside = f" ± {number(uncertainty * scale, 2)}" if uncertainty else ""
    return number(row["value"], 6) + beside


def reason(row):
    """Why a row may differ as it does, and on what it rests."""
    if row["verdict"] == "deviates (explained)":
        return f"{row['explanation']} (explains up to {amount(row, row['covers'])})"
    rests = row.get("rests_on")
    return row["reason"] + (f"; rests on {rests} data" if rests else "")


def difference(row):
    """Difference of a row; see ``amount``."""
    return "–" if row.get("above") else amount(row, row["difference"], sign=True)


def amount(row, value, sign=False):
    """A difference in the unit of a row's scale: a percentage of the reference, or of the scale,
    which is named then; a plain number where the scale is 1."""
    scale = row.get("scale")
    if scale == 1.0 or scale is None and row["reference"] == 0.0:
        return ("+" if sign and value > 0.0 else "") + number(value, 2)
    text = percent(value, sign=sign) if 1e-4 <= abs(value) < 10.0 else number(value, 2)
    return text if scale is None else f"{text} of {number(scale, 3)}"


def case_title(definition):
    """Title of a case without the numbers of section and tables."""
    return definition.title.partition(" (")[0]


def shown(value):
    """A value of a definition file."""
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, (list, tuple)):
        return "(" + ", ".join(shown(item) for item in value) + ")"
    return str(value)


def number(value, digits):
    """A number of so many digits; ``–`` for none."""
    if value is None or value != value:
        return "–"
    if 10.0**digits <= abs(value) < 1e6:
        return f"{value:.0f}"
    if isinstance(value, int) or value == 0 or 1e-3 <= abs(value) < 1e6:
        return f"{value:#.{digits}g}".rstrip(".") if value and not float(
            value).is_integer() else f"{value:.0f}"
    mantissa, exponent = f"{value:.{min(digits, 4) - 1}e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def percent(value, digits=3, sign=False):
    """A fraction as a percentage, to two digits at least; ``–`` for none."""
    if value is None or value != value:
        return "–"
    if 0.0 < abs(value) < 1e-4:
        mantissa, exponent = f"{100.0 * value:{'+' if sign else ''}.1e}".split("e")
        return f"{mantissa}e{int(exponent)}%"
    return f"{value + 0.0:{'+' if sign and value else ''}.{digits}%}"


def duration(seconds, extrapolated=False):
    """Seconds in the unit that suits them."""
    if seconds is None or seconds != seconds:
        return "–"
    mark = "*" if extrapolated else ""
    if seconds < 100.0:
        return f"{seconds:.3g} s{mark}"
    if seconds < 3600.0:
        return f"{seconds / 60.0:.3g} min{mark}"
    return f"{seconds / 3600.0:.4g} h{mark}"
