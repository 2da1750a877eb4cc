"""The page: reads what verification, convergence, timing and the runs wrote, and renders it."""

import base64
import datetime
import json
import tomllib
from importlib import metadata
from importlib.resources import files
from pathlib import Path
from types import SimpleNamespace

from jinja2 import Environment, PackageLoader, StrictUndefined

from convergence.claims import claims, mesh_claims
from convergence.study import printed_results
from convergence.verdicts import assumptions
from solver import ResultFileError
from solver.cases import load_case
from solver.provenance import commit, machine, usable_cores, versions
from timing.tables import TABLES
from timing.verdicts import verdicts as timing_verdicts
from verification.registry import CASES as VERIFICATION

from . import figures, tables
from .drawings import DRAWINGS, LOST, TOPICS, Sources, available, figures_of, read_json
from .parts import (
    Stamps,
    parts,
    plan,
    run_file,
    status,
    study_file,
    suite_file,
    suite_names,
    timing_file,
)
from .player import packed_text, player
from .recording import Recording
from .tables import Cell, worst

FINDINGS = Path(__file__).with_name("findings.toml")

CASES = ("l-plate", "ruler", "hemisphere", "plates")
"""In the order of the paper's section 4."""

TIMES = dict(zip(CASES, TABLES))
"""The table of CPU times of each case."""

SHORT = {"l-plate": "L-plate", "ruler": "ruler", "hemisphere": "hemisphere",
         "plates": "three plates"}

SUITES = {"patch": "constant states", "kernel": "element, step", "linear": "MacNeal-Harder",
          "nonlinear": "Sze, Liu and Lo", "rotations": "1000 turns",
          "dynamics": "order, frequencies", "junctions": "folds", "benchmarks": "symmetry",
          "mutants": "wrong variants"}
"""What the verification suites are about, in a few words."""

OF_STUDY = {"Figure 5": ("slope", "R squared"), "Figure 12": ("Fig. 12",)}
"""Figures whose verdicts are rows of the convergence study, by what is in their names."""

PIXELS = 110
"""Pixels of the page for an inch of a picture."""

LARGEST_SVG = 400_000
"""Bytes beyond which a picture is embedded as PNG; its SVG lies beside the page all the same."""


def build(size, folder):
    """Write ``folder``/page/index.html and its figures from whatever results are there.

    Returns:
        Path: of the page.
    """
    page = folder / "page"
    (page / "figures").mkdir(parents=True, exist_ok=True)
    everything = parts(size, folder)
    stamps = Stamps(folder / "parts")
    cases = [_case(name, size, folder, page / "figures") for name in CASES]
    suites = [_suite(suite, folder) for suite in suite_names()]
    timing = {name: read_json(timing_file(folder, name))
              for name in ("targets", "iterations", "growth")}
    environment = Environment(loader=PackageLoader("reports"), undefined=StrictUndefined,
                              autoescape=True, trim_blocks=True, lstrip_blocks=True)
    players = {case.name: case.player for case in cases if case.player}
    html = environment.get_template("page.html").render(
        about=_about(size, everything, stamps),
        counts=tables.counts([row for part in (*cases, *suites) for row in part.rows]),
        cases=cases, suites=suites, grid=_grid(cases, suites), findings=_findings(folder),
        verdicts=tables.VERDICTS, words=tables.WORDS, speed=_speed(timing),
        parts=_parts_table(everything, stamps),
        style=_text("page.css"), script=_text("player.js"),
        players={name: json.dumps(data) for name, data in players.items()},
        plotly=_plotly() if players else "")
    path = page / "index.html"
    path.write_text(html, encoding="utf-8")
    return path


def _case(name, size, folder, pictures):
    """Everything that the page shows of a case."""
    definition = load_case(name)
    study = read_json(study_file(folder, name, size))
    timing = read_json(timing_file(folder, TIMES[name]))
    recordings, problems = _recordings(name, size, folder)
    sources = Sources(definition, recordings, study)
    claimed = _claims(name, recordings, study)
    printed = printed_results(name)
    time_rows = [row.as_dict() for row in timing_verdicts(
        timing["tables"][f"{TIMES[name]}-ratios"])] if timing else []
    energy_rows = [row for row in study["verdicts"] if row["kind"] == "published"] if study else []
    promise_rows = [row for row in study["verdicts"] if row["kind"] != "published"] if study else []
    return SimpleNamespace(
        name=name, short=SHORT[name], title=tables.case_titles()[name], rows=[
            *energy_rows, *promise_rows, *time_rows,
            *(row for claim in claimed.values() for row in claim.rows)],
        section=definition.title.partition("(")[2][:11],
        assumptions=assumptions(definition), counts=tables.provenance_counts(name),
        provenance=tables.provenance(name), claims=claimed, problems=problems,
        figures=[_figure(label, sources, claimed, pictures)
                 for label in dict.fromkeys(drawing.figure for drawing in DRAWINGS[name])],
        energies=tables.energies(study, printed), rates=tables.rates(study) if study else None,
        energy_cell=_cell(printed["table"], energy_rows, f"energy, {SHORT[name]}"),
        promise_cell=_cell(SHORT[name], promise_rows, "step, drift, damping",
                           href=f"#{name}-study"),
        study_rows=tables.verdict_rows("Verdicts of the study", study["verdicts"])
        if study else None,
        times=tables.times(TIMES[name], timing),
        ratios=tables.ratios(TIMES[name], timing) if timing else None,
        time_cell=_cell(TABLES[TIMES[name]], time_rows, f"CPU time, {SHORT[name]}"),
        commands=[f"corovec converge {name} --size {size}", f"corovec time {TIMES[name]}"],
        run=recordings[-1].contents["description"] if recordings else None,
        player=player(recordings[-1]) if recordings else None)


def _recordings(case, size, folder):
    """(recordings of the runs of a case that are finished, the coarsest first; what is wrong)."""
    found, problems = [], []
    for run in sorted(plan(size)[case], key=lambda run: run["elements"]):
        path = run_file(folder, case, run["elements"])
        if path.exists():
            try:
                recording = Recording.open(path)
                if recording.contents["step"] == recording.contents["n_steps"]:
                    found.append(recording)
            except ResultFileError as error:
                problems.append(str(error))
    return found, problems


def _claims(case, recordings, study):
    """``{figure: rows and cell}`` of all figures of a case."""
    found = {figure: [] for figure in figures_of(case)}
    found[next(iter(found))] = [row.as_dict() for row in mesh_claims(case)]
    if recordings:
        runs = {recording.elements: recording.contents for recording in recordings}
        for figure, rows in claims(case, runs).items():
            found[figure] = [row.as_dict() for row in rows]
    for figure, texts in OF_STUDY.items():
        if study and figure in found:
            found[figure] = [row for row in study["verdicts"]
                             if any(text in row["name"] for text in texts)]
    return {figure: SimpleNamespace(
        cell=_cell(figure, rows, f"{TOPICS[figure]}, {SHORT[case]}"), rows=rows)
        for figure, rows in found.items()}


def _figure(label, sources, claimed, folder):
    """A figure of the paper: its drawings, what it claims with verdicts, and what is lost of it."""
    own = [claim for figure, claim in claimed.items() if figure.rstrip("ab") == label]
    drawn = [SimpleNamespace(
        name=drawing.name, title=drawing.title,
        picture=_picture(drawing, sources, folder) if available(drawing, sources) else None)
        for drawing in DRAWINGS[sources.case.name] if drawing.figure == label]
    return SimpleNamespace(
        label=label, id=_anchor(label), cells=[claim.cell for claim in own], drawings=drawn,
        lost=LOST.get(label), table=tables.verdict_rows(
            "What the paper says of it", [row for claim in own for row in claim.rows]))


def _picture(drawing, sources, folder):
    """A drawing, written beside the page and ready to be embedded."""
    figure, data = drawing.draw(sources)
    svg, png, csv = figures.save(figure, data, folder, drawing.name, overwrite=True)
    shown = png if drawing.dense or svg.stat().st_size > LARGEST_SVG else svg
    kind = "image/png" if shown is png else "image/svg+xml"
    content = base64.b64encode(shown.read_bytes()).decode("ascii")
    return SimpleNamespace(source=f"data:{kind};base64,{content}",
                           width=round(PIXELS * figure.get_size_inches()[0]),
                           files=[f"figures/{path.name}" for path in (svg, png, csv)])


def _suite(name, folder):
    """A verification suite: its cases with their rows, and its cell."""
    cases = [case for case in VERIFICATION if case.suite == name]
    report = read_json(suite_file(folder, name))
    results = {case["name"]: case for case in report["cases"]} if report else {}
    shown = []
    for case in cases:
        result = results.get(case.name)
        rows = result["rows"] if result else []
        error = result["error"] if result else None
        shown.append(SimpleNamespace(
            name=case.name, claim=case.claim, source=case.source, definition=case.definition,
            seconds=tables.duration(result["seconds"]) if result else "", error=error,
            cell=_cell(case.name, rows, error=error), table=tables.verdict_rows("", rows)))
    rows = [row for result in results.values() for row in result["rows"]]
    failed = next((case.error for case in shown if case.error), None)
    cell = _cell(name, rows, SUITES[name], failed, f"#verify-{name}")
    return SimpleNamespace(name=name, cases=shown, cell=cell, rows=rows,
                           command=f"corovec verify {name}")


def _cell(label, rows, topic="", error=None, href=None):
    """The grid's cell of some rows: their worst verdict, and how many there are of each."""
    verdicts = [row["verdict"] for row in rows] + (["failed"] if error else [])
    return Cell(label, worst(verdicts), topic, error or tables.summary(rows),
                href or f"#{_anchor(label)}")


def _grid(cases, suites):
    """Groups of cells of the first screen."""
    figure_cells = {label: claim.cell for case in cases for label, claim in case.claims.items()}
    lost = [Cell(figure, "not reproducible", "curves of other authors", text,
                 f"#{_anchor(figure)}-lost") for figure, text in LOST.items()]
    by_table = sorted([case.energy_cell for case in cases] + [case.time_cell for case in cases],
                      key=lambda cell: cell.label)
    return [("Tables", by_table), ("Figures", [*figure_cells.values(), *lost]),
            ("Time step, conservation, dissipation", [case.promise_cell for case in cases]),
            ("Verification suites", [suite.cell for suite in suites])]


def _findings(folder):
    """The findings, each with the rows of the verification cases that show it."""
    with open(FINDINGS, "rb") as file:
        groups = tomllib.load(file)
    reports = {}
    for suite in suite_names():
        report = read_json(suite_file(folder, suite))
        reports |= {case["name"]: case["rows"] for case in report["cases"]} if report else {}
    return [SimpleNamespace(title=group["title"], items=[
        SimpleNamespace(**{"where": "", **finding}, evidence=_evidence(finding, reports))
        for finding in group["finding"]]) for group in groups.values()]


def _evidence(finding, reports):
    """Table of the rows that a finding points to; None if their case was not run."""
    rows = [row for row in reports.get(finding.get("case"), ())
            if any(text in row["name"] for text in finding.get("rows", ("",)))]
    return tables.verdict_rows(f"corovec verify {finding['case']}", rows) if rows else None


def _speed(timing):
    """Tables of what goes beyond the paper's timings."""
    makers = {"targets": tables.targets, "iterations": tables.iterations, "growth": tables.growth}
    return [SimpleNamespace(table=make(timing[name]) if timing[name] else None,
                            command=f"corovec time {name}") for name, make in makers.items()]


def _about(size, everything, stamps):
    """Where and when: the line below the title."""
    seconds = sum((stamps.read(part) or {}).get("seconds") or 0.0 for part in everything)
    return SimpleNamespace(
        size=size, date=datetime.datetime.now().isoformat(" ", timespec="minutes"),
        commit=commit(), machine=machine(), cores=usable_cores(), versions=versions(),
        seconds=tables.duration(seconds), command=f"corovec reproduce --size {size}")


def _parts_table(everything, stamps):
    """How every part ended."""
    rows = []
    for part in everything:
        stamp = stamps.read(part)
        rows.append([part.name, status(part, stamps), tables.duration(
            stamp and stamp["seconds"]), part.shown(), (stamp or {}).get("message", "")])
    return tables.Table("Parts", ("part", "status", "wall clock", "command", "message"), rows)


def _anchor(label):
    """``Figure 16a`` -> ``figure-16a``."""
    return label.lower().replace(" ", "-")


def _text(name):
    return files("reports").joinpath("templates", name).read_text(encoding="utf-8")


def _plotly():
    """The library that draws the players, packed, with its version."""
    from plotly.offline import get_plotlyjs
    return SimpleNamespace(code=packed_text(get_plotlyjs()), version=metadata.version("plotly"))
