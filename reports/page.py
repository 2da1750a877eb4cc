"""The page: reads what verification, convergence, timing and the runs wrote, and renders it."""

import base64
import datetime
import json
import tomllib
from dataclasses import replace
from functools import partial
from importlib import metadata
from importlib.resources import files
from pathlib import Path
from types import SimpleNamespace

from jinja2 import Environment, PackageLoader, StrictUndefined

from corovec.benchmarks import load_case
from corovec.convergence.study import printed_results
from corovec.convergence.verdicts import assumptions
from corovec.solver.results.files import replacing
from corovec.solver.runtime.execution import complete, processes_of
from corovec.solver.runtime.provenance import commit, machine, usable_cores, versions
from corovec.timing.tables import TABLE_OF, TABLES
from corovec.verification.case import CHOSEN
from corovec.verification.registry import CASES as VERIFICATION

from . import changes, conservation, figures, tables
from .drawings import Sources, benchmarks
from .parts import (
    SIZES,
    Lack,
    Results,
    conservation_file,
    plan,
    run_file,
    status,
    study_file,
    suite_names,
)
from .player import packed_text, player
from .processes import context
from .records import load, records_of
from .style import targets
from .tables import Cell, anchored, distinct, leading, worst

FINDINGS = Path(__file__).with_name("findings.toml")

SUITES = {"patch": "constant states", "kernel": "element, step", "linear": "MacNeal-Harder",
          "stresses": "hole, roof", "sections": "laminates, heat",
          "nonlinear": "Sze, Liu and Lo", "rotations": "1000 turns",
          "dynamics": "order, frequencies", "exact": "the exact scheme",
          "joints": "hinges", "junctions": "folds", "vibration": "modes, spin",
          "buckling": "plate, column, cylinder", "benchmarks": "symmetry",
          "mutants": "wrong variants"}
"""What the verification suites are about, in a few words."""

PIXELS = 110
"""Pixels of the page for an inch of a picture."""

LARGEST_SVG = 400_000
"""Bytes beyond which a picture is embedded as PNG; its SVG lies beside the page all the same."""


def build(size, folder, jobs=1):
    """Write ``folder``/page/index.html and its figures from the results of the finished parts.

    Args:
        jobs: cases drawn at a time, each in a process of its own if more than one.

    Returns:
        Path: of the page.
    """
    page = folder / "page"
    (page / "figures").mkdir(parents=True, exist_ok=True)
    results = Results(size, folder)
    cases = _cases(partial(_case, size=size, folder=folder), jobs)
    suites = [_suite(suite, results) for suite in suite_names()]
    schemes = _schemes(results, size, folder)
    environment = Environment(loader=PackageLoader(__package__), undefined=StrictUndefined,
                              autoescape=True, trim_blocks=True, lstrip_blocks=True)
    players = {case.name: case.player for case in cases if case.player}
    html = environment.get_template("page.html").render(
        about=_about(size, results),
        compared=tables.compared(distinct([row for part in (*cases, *suites, schemes)
                                           for row in part.rows])),
        standing=tables.standing([pair for case in cases for pair in case.labelled]),
        cases=cases, suites=suites, schemes=schemes, grid=_grid(cases, suites, schemes),
        findings=_findings(suites),
        verdicts=tables.VERDICTS, words=tables.WORDS, speed=_speed(results),
        parts=_parts_table(results), changes=_changes(results, folder),
        style=_text("page.css"), script=_text("player.js"),
        players={name: json.dumps(data) for name, data in players.items()},
        plotly=_plotly() if players else "")
    path = page / "index.html"
    with replacing(path) as draft:
        draft.write_text(html, encoding="utf-8", errors="backslashreplace")
    return path


def _cases(case, jobs):
    """``case(name)`` of all cases."""
    names, made = list(benchmarks()), {}
    for name, shown, error in complete(processes_of(context(), jobs), case, names):
        if error is not None:
            raise error
        made[name] = shown
    return [made[name] for name in names]


def _case(name, size, folder):
    """Everything that the page shows of a case; writes its figures."""
    shown, definition, results = benchmarks()[name], load_case(name), Results(size, folder)
    study, no_study = results.read(f"converge-{name}")
    if study:
        study["verdicts"] = anchored(study["verdicts"], f"{name}-study")
    recordings, no_runs = _recordings(name, size, results)
    failed = [Lack("failed", run["error"]) for run in study["runs"]
              if run["status"] == "failed"] if study else []
    sources = Sources(definition, recordings, study)
    claimed = _claims(shown, results, no_runs, study, no_study, size)
    printed, timed = printed_results(name), _times(shown, results)
    energy_rows = [row for row in study["verdicts"] if row["kind"] == "published"] if study else []
    promise_rows = [row for row in study["verdicts"] if row["kind"] != "published"] if study else []
    labelled = [(printed["table"] if printed else "", energy_rows),
                *((timed.cell.label, timed.rows) for _ in (timed,) if timed),
                *((label, claim.rows) for label, claim in claimed.items()),
                (f"{shown.short}, study", promise_rows)]
    return SimpleNamespace(
        name=name, short=shown.short, flight=definition.paper.time,
        lost={figure.label: figure.lost for figure in shown.figures if figure.lost},
        title=tables.case_title(definition),
        shown=sorted((label for label, _ in labelled[:-1] if label),
                     key=lambda label: not label.startswith("Table")),
        labelled=labelled, rows=[row for _, own in labelled for row in own],
        section=definition.title.partition("(")[2][:11],
        assumptions=assumptions(definition), counts=tables.provenance_counts(definition),
        provenance=tables.provenance(definition), claims=claimed,
        lacks=SimpleNamespace(study=no_study + failed, runs=no_runs),
        figures=[_figure(figure, sources, claimed, size, folder) for figure in shown.figures],
        energies=tables.energies(study, printed) if printed else None,
        rates=tables.rates(study) if study else None,
        kept=tables.kept([row for _, own in labelled for row in own],
                         {name for names in (printed or {}).get("claims", {}).values()
                          for name in names}),
        energy_cell=replace(_cell(printed["table"], energy_rows, no_study,
                                  f"energy, {shown.short}"), beside=tables.apart(energy_rows))
        if printed else None,
        promise_cell=_cell(shown.short, promise_rows, no_study + failed,
                           "step, drift, damping", f"{name}-study"),
        study_rows=tables.verdict_rows("Verdicts of the study", study["verdicts"], f"{name}-study")
        if study else None, timed=timed, command=f"corovec converge {name} --size {size}",
        run=recordings[-1].contents["description"] if recordings else None,
        player=player(recordings[-1]) if recordings else None)


def _times(shown, results):
    """The table of CPU times of a case, its ratios and its cell; None if the paper has none."""
    if shown.name not in TABLE_OF:
        return None
    name = TABLE_OF[shown.name]
    timing, lacks = results.read(f"time-{name}")
    rows = anchored(timing["tables"][f"{name}-verdicts"], name) if timing else []
    return SimpleNamespace(
        rows=rows, lacks=lacks, times=tables.times(name, timing), command=f"corovec time {name}",
        ratios=tables.ratios(name, timing, rows) if timing else None,
        cell=replace(_cell(TABLES[name], rows, lacks, f"CPU time, {shown.short}"),
                     beside=tables.ratio_apart(rows)))


def _recordings(case, size, results):
    """(recordings of the finished runs of a case, the coarsest first; lacks of the others)."""
    read = [results.read(f"run-{case}-{elements}")
            for elements in sorted(run["elements"] for run in plan(size).get(case, ()))]
    return ([recording for recording, _ in read if recording],
            [lack for _, lacks in read for lack in lacks])


def _claims(shown, results, no_runs, study, no_study, size):
    """``{label: rows and cell}`` of all figures of a case that have a verdict."""
    checked, no_claims = results.read(f"claims-{shown.name}")
    drawn = max((run["elements"] for run in plan(size).get(shown.name, ())), default=0)
    made = {}
    for label, (figure, topic) in shown.verdicts.items():
        rows, lacks = checked["figures"].get(label, []) if checked else [], no_runs + no_claims
        rows = anchored(rows, "-".join(filter(None, (
            _anchor(figure.label), label.removeprefix(figure.label)))))
        named = (*figure.of_study, *(f"{drawn} {tables.ENERGY}",) * figure.level)
        studied = [row for row in (study["verdicts"] if study else ())
                   if any(text in row["name"] for text in named)]
        if figure.not_reproducible:
            lacks = [Lack("not reproducible", figure.not_reproducible)]
        elif named:
            lacks = no_study if figure.of_study else lacks + no_study
        made[label] = SimpleNamespace(rows=rows + studied, cell=_figure_cell(
            label, rows + studied, lacks, f"{topic}, {shown.short}"))
    return made


def _figure_cell(label, rows, lacks, topic):
    """Of a figure whose statements hold it is only said that it is drawn, and what was compared."""
    cell = _cell(label, rows, lacks, topic)
    if rows and worst([cell.verdict, "drawn"]) == "drawn":
        cell = replace(cell, verdict="drawn", href=f"#{cell.id}",
                       rests_on=cell.verdict if cell.verdict in CHOSEN else "")
    return replace(cell, beside=f"compared: {tables.summary(rows)}" if rows else "")


def _figure(figure, sources, claimed, size, folder):
    """A figure of the paper: its drawings, what it claims with verdicts, and what is lost of it."""
    own = [claimed[label] for label in figure.verdicts]
    drawn = [SimpleNamespace(name=drawing.name, title=drawing.title,
                             picture=_picture(drawing, sources, folder / "page" / "figures"),
                             made_from=_made_from(drawing, sources, size, folder))
             for drawing in figure.drawings]
    return SimpleNamespace(
        label=figure.label, id=_anchor(figure.label), cells=[claim.cell for claim in own],
        drawings=drawn, lost=figure.lost, table=tables.verdict_rows(
            "What is compared of it", distinct([row for claim in own for row in claim.rows]),
            _anchor(figure.label)))


def _picture(drawing, sources, folder):
    """A drawing, written beside the page and ready to be embedded; None without its results, and
    then that of an earlier page is removed."""
    if not drawing.available(sources):
        for path in targets(folder, drawing.name):
            path.unlink(missing_ok=True)
        return None
    figure, data = drawing.draw(sources)
    svg, png, csv = figures.save(figure, data, folder, drawing.name, overwrite=True)
    shown = png if drawing.dense or svg.stat().st_size > LARGEST_SVG else svg
    kind = "image/png" if shown is png else "image/svg+xml"
    content = base64.b64encode(shown.read_bytes()).decode("ascii")
    return SimpleNamespace(source=f"data:{kind};base64,{content}",
                           width=round(PIXELS * figure.get_size_inches()[0]),
                           height=round(PIXELS * figure.get_size_inches()[1]),
                           files=[f"figures/{path.name}" for path in (svg, png, csv)])


def _made_from(drawing, sources, size, folder):
    """What a drawing is made from: in words meshes, time steps, end times, and where the data of
    the case comes from; and its files, those of results from their ``folder``."""
    case, runs = sources.case, drawing.recordings(sources)
    files = [run_file(folder, case.name, run.elements) for run in runs]
    solved = [{"elements": run.elements, **run.contents["description"]["settings"]} for run in runs]
    if drawing.kind == "convergence" and sources.study:
        files, solved = [study_file(folder, case.name, size)], sources.study["mesh"]
    meshes = {}
    for run in solved:
        meshes.setdefault((run["dt"], run["end_time"]), []).append(str(run["elements"]))
    words = [f"{', '.join(sizes)} elements, dt = {dt:g} s, until {end:g} s"
             for (dt, end), sizes in meshes.items()]
    counts = ", ".join(f"{n} {kind}" for kind, n in tables.provenance_counts(case).items())
    return SimpleNamespace(
        words="; ".join([*(words or [f"{case.defaults.elements} elements"]),
                         f"data of the case: {counts}"]),
        files=[path.relative_to(folder).as_posix() for path in files]
        or [f"corovec/benchmarks/{case.name}.toml"])


def _schemes(results, size, folder):
    """The schemes side by side: tables, drawings, verdicts and their cell; writes its figures."""
    study, lacks = results.read("conserve")
    rows = anchored(study["verdicts"], "conservation") if study else []
    file = conservation_file(folder, size).relative_to(folder).as_posix()
    drawn = [SimpleNamespace(name=drawing.name, title=drawing.title,
                             picture=_picture(drawing, study, folder / "page" / "figures"),
                             made_from=study and drawing.made_from(study, file))
             for drawing in conservation.DRAWINGS]
    named = [{**row, "name": f"{row['case']}, {row['name']}"} for row in rows]
    return SimpleNamespace(
        rows=rows, lacks=lacks, command=f"corovec conserve --size {size}",
        drawings=[each for each in drawn if each.picture],
        tables=[conservation.largest(study), conservation.flights(study)] if study else [],
        summary=conservation.summary(study) if study else "",
        verdicts=tables.verdict_rows("Verdicts", named, "conservation"),
        cell=_cell("schemes", rows, lacks, "the exact one beside the others", "conservation"))


def _suite(name, results):
    """A verification suite: its cases with their rows, and its cell."""
    report, no_report = results.read(f"verify-{name}")
    ended = {case["name"]: case for case in report["cases"]} if report else {}
    shown = []
    for case in [case for case in VERIFICATION if case.suite == name]:
        lacks = no_report or [Lack("not run", f"{case.name}: not run")]
        result = ended.get(case.name, {"rows": [], "error": None, "seconds": None})
        rows, error = anchored(result["rows"], f"case-{case.name}"), result["error"]
        if case.name in ended:
            lacks = [Lack("failed", f"{case.name}: {error}")] if error else []
        shown.append(SimpleNamespace(
            case=case, rows=rows, lacks=lacks, seconds=tables.duration(result["seconds"]),
            cell=_cell(case.name, rows, lacks, section=f"verify-{name}"),
            table=tables.verdict_rows("", rows, f"case-{case.name}")))
    rows = [row for item in shown for row in item.rows]
    lacks = list(dict.fromkeys(lack for item in shown for lack in item.lacks))
    return SimpleNamespace(name=name, cases=shown, rows=rows, lacks=lacks,
                           command=f"corovec verify {name}",
                           cell=_cell(name, rows, lacks, SUITES.get(name, ""), f"verify-{name}"))


def _cell(label, rows, lacks, topic="", section=None):
    """The grid's cell of some rows: the worst of their verdicts and of what lacks, and why; leads
    to the first row that gave it, or to the section."""
    verdict = worst([lack.verdict for lack in lacks] + [row["verdict"] for row in rows])
    detail = [*(lack.why for lack in lacks), *([tables.summary(rows)] if rows else [])]
    giving = next((row for row in rows if row["verdict"] == verdict), {})
    return Cell(label, verdict, topic, "; ".join(detail),
                leading(giving) or f"#{section or _anchor(label)}")


def _grid(cases, suites, schemes):
    """Groups of cells of the first screen."""
    figure_cells = {label: claim.cell for case in cases for label, claim in case.claims.items()}
    lost = [Cell(label, "not reproducible", "curves of other authors", text,
                 f"#{_anchor(label)}-lost") for case in cases for label, text in case.lost.items()]
    by_table = sorted([*(case.energy_cell for case in cases if case.energy_cell),
                       *(case.timed.cell for case in cases if case.timed)],
                      key=lambda cell: cell.label)
    return [("Tables", by_table), ("Figures", [*figure_cells.values(), *lost]),
            ("Time step, conservation, dissipation",
             [*(case.promise_cell for case in cases), schemes.cell]),
            ("Verification suites", [suite.cell for suite in suites])]


def _findings(suites):
    """The findings, each with the rows of the verification cases that show it, or why there are
    none."""
    with open(FINDINGS, "rb") as file:
        groups = tomllib.load(file)
    cases = {item.case.name: item for suite in suites for item in suite.cases}
    return [SimpleNamespace(title=group["title"], items=[
        SimpleNamespace(**{"where": "", **finding}, **_evidence(finding, cases))
        for finding in group["finding"]]) for group in groups.values()]


def _evidence(finding, cases):
    """Table of the rows that a finding points to (None without), and what lacks of it."""
    names = finding.get("cases", ())
    rows = [row for name in names for row in cases[name].rows
            if any(text in row["name"] for text in finding.get("rows", ("",)))]
    table = tables.verdict_rows(f"corovec verify {' '.join(names)}", rows) if rows else None
    lacks = [lack for name in names for lack in cases[name].lacks]
    return {"evidence": table, "lacks": list(dict.fromkeys(lacks))}


def _speed(results):
    """Tables of what goes beyond the paper's timings."""
    makers = {"targets": (tables.targets,), "growth": (tables.phases, tables.growth),
              "iterations": (tables.iterations, tables.accumulation)}
    read = {name: results.read(f"time-{name}") for name in makers}
    return [SimpleNamespace(tables=[make(read[name][0]) for make in made] if read[name][0] else [],
                            lacks=read[name][1], command=f"corovec time {name}")
            for name, made in makers.items()]


def _about(size, results):
    """Where and when: the line below the title."""
    seconds = sum((results.stamps.read(part) or {}).get("seconds") or 0.0
                  for part in results.parts.values())
    return SimpleNamespace(
        size=size, means=SIZES[size],
        date=datetime.datetime.now().isoformat(" ", timespec="minutes"),
        commit=commit(), machine=machine(), cores=usable_cores(), versions=versions(),
        seconds=tables.duration(seconds), command=f"corovec reproduce --size {size}")


def _changes(results, folder):
    """What moved since the last records: in one line, and as a table if anything did."""
    read = [(part.result, results.read(name)[0]) for name, part in results.parts.items()
            if part.kind in ("converge", "time")]
    compared = changes.compare(records_of(each for each in read if each[1]), *load(folder))
    return SimpleNamespace(line=compared.line(), table=changes.table(compared)
                           if compared.changes else None)


def _parts_table(results):
    """How every part ended."""
    rows = []
    for part in results.parts.values():
        stamp = results.stamps.read(part)
        rows.append([part.name, status(part, results.stamps), tables.duration(
            stamp and stamp["seconds"]), part.shown(), (stamp or {}).get("message", "")])
    return tables.Table("Parts", ("part", "status", "wall clock", "command", "message"), rows)


def _anchor(label):
    return Cell(label, "").id


def _text(name):
    return files(__package__).joinpath("templates", name).read_text(encoding="utf-8")


def _plotly():
    """The library that draws the players, packed, with its version."""
    from plotly.offline import get_plotlyjs
    return SimpleNamespace(code=packed_text(get_plotlyjs()), version=metadata.version("plotly"))
