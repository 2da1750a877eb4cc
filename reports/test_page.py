"""The page of small results: verdicts as the suites gave them, whole in a browser, players play."""

import gzip
import json
import os
import re
import shutil
import tomllib
from base64 import b64decode
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from corovec import InputError, Settings, benchmarks, convergence, simulate, solver, verification
from corovec import timing as timing_package
from corovec.benchmarks import load_case
from corovec.convergence import claims
from corovec.convergence.claims import open_runs
from corovec.convergence.run import code_version
from corovec.reports import drawings, page, parts, processes, reproduce, tables
from corovec.reports.cli import reproduce as command
from corovec.reports.parts import Part, Results, Stamps
from corovec.reports.player import STEPS, player
from corovec.reports.recording import Recording
from corovec.reports.records import keep, records_of
from corovec.timing.measure import Sample
from corovec.timing.printed import cells
from corovec.timing.solvers import METHODS
from corovec.timing.tables import ratios
from corovec.timing.targets import Target
from corovec.timing.verdicts import verdicts
from corovec.verification.case import Row, small
from corovec.verification.registry import Outcome, find, make_report

SIZE = "quick"
FRAMES = 61
WRITTEN = {"date": "2026-01-02", "machine": {"processor": "one"}, "versions": {}}
DEVIATING = {"name": "30 elements: energy after unloading [J]", "value": 70.6, "reference": 71.373,
             "kind": "published", "tolerance": 7e-6, "reason": "last digit", "above": False,
             "explanation": "", "covers": 0.0, "difference": -0.011, "verdict": "deviates (open)"}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A folder with runs, a suite, a study and a timing, small or made up."""
    folder = tmp_path_factory.mktemp("results")
    finish(folder, "verify-kernel", suite("kernel"))
    finish(folder, "verify-patch", {**suite("patch"), "cases": suite("patch")["cases"][1:]})
    finish(folder, "converge-l-plate", study())
    finish(folder, "conserve", schemes())
    finish(folder, "time-table-2", timing())
    finish(folder, "converge-plates", status="failed")
    settings = Settings(dt=0.02, end_time=1.2, frame_every=1)
    runs = [parts.run_file(folder, "l-plate", elements) for elements in (30, 120, 480)]
    runs[0].parent.mkdir(parents=True)
    simulate(load_case("l-plate").model(30), settings, output=runs[0], case="l-plate")
    for path in runs[1:]:
        shutil.copy(runs[0], path)
    for elements in (30, 120, 480):
        finish(folder, f"run-l-plate-{elements}")
    finish(folder, "claims-l-plate", claimed("l-plate", open_runs("l-plate", runs[:1])))
    finish(folder, "claims-ruler", claimed("ruler", {}))
    return folder


def claimed(case, runs):
    """What ``corovec claims`` writes."""
    return claims.as_json(case, runs, claims.claims(case, runs))


@pytest.fixture(scope="module")
def html(results):
    return page.build(SIZE, results).read_text(encoding="utf-8")


def finish(folder, name, contents=None, status="finished"):
    """The stamp of a part, and its result."""
    part = Results(SIZE, folder).parts[name]
    part.result.parent.mkdir(parents=True, exist_ok=True)
    (folder / "parts").mkdir(exist_ok=True)
    if contents:
        part.result.write_text(json.dumps(contents), encoding="utf-8")
    Stamps(folder / "parts").write(part, status, 1.0, "disk <full>" if status == "failed" else "")
    return part


def suite(name):
    """Report of a suite whose cases have one row each."""
    rows = [small("nothing", 0.0, 1e-9, "rounding")]
    return make_report([Outcome(case, rows) for case in find([name])], "2000-01-01", True)


def study():
    """A convergence study of one mesh."""
    mesh = {"elements": 30, "dt": 0.01, "end_time": 1.2, "energy": 70.6, "energy_limit": 70.59,
            "limit_uncertainty": 0.01, "difference": -0.011, "error_of_printed": 0.02,
            "error": 0.03, "order_of_printed": None, "order": None}
    slope = {"quantity": "slope, finest mesh as reference", "unit": "", "ours": -2.0,
             "of_printed": -1.7, "of_all_printed": -1.27, "printed": "-1.27", "note": ""}
    drift = {**DEVIATING, "name": "energy drift", "kind": "analytic", "verdict": "match"}
    rate = {**DEVIATING, "name": "slope", "verdict": "deviates (explained)"}
    return {"mesh": [mesh], "summary": [slope], "verdicts": [DEVIATING, drift, rate],
            "runs": [{"status": "finished", "error": "", "case": "l-plate",
                      "membrane": "stress"}],
            "origin": {"commit": "new", "size": SIZE, **WRITTEN}}


def timing():
    """CPU times of Table 2: our dense/skyline is 1.1 of the paper's."""
    rows = []
    for cell in cells():
        if cell.table == "Table 2" and cell.method == "skyline":
            dense = next(c for c in cells() if (c.table, c.elements, c.method) == (
                "Table 2", cell.elements, "dense"))
            for method in METHODS:
                row_cell = {"skyline": cell, "dense": dense}.get(method)
                rows.append({
                    "table": "Table 2", "case": "l-plate", "elements": cell.elements,
                    "method": method, "basis": "steps",
                    **Sample((1.25, 1.0, 1.5), (1.0,)).row("unit"),
                    "run_cpu": 8e3, "run_extrapolated": True, "factor_cpu": 1.0, "solve_cpu": 0.1,
                    "unknowns": 240, "storage_bytes": 40560,
                    "step_cpu": 1.1 * dense.seconds if method == "dense" else cell.seconds,
                    "paper_seconds": row_cell and row_cell.seconds,
                    "printed_seconds": row_cell and row_cell.printed_seconds})
    compared = ratios(rows)
    return {"tables": {"table-2-times": rows, "table-2-ratios": compared,
                       "table-2-verdicts": [row.as_dict() for row in verdicts(compared)]},
            "references": {"table-2": Sample((1.0,), (1.0,)).row("LU")}, "commit": "new",
            "size": SIZE, **WRITTEN}


def cell(html, label):
    """(verdict, target) of a cell of the first screen."""
    found = re.search(rf'<li><a href="(#[^"]+)"[^>]*><b>{label}</b>.*?<span class="badge [^"]*">'
                      r"([^<]+)</span>", html)
    return found[2], found[1]


def test_every_table_figure_and_suite_has_a_cell_that_leads_to_it(html):
    labels = [*(f"Table {k}" for k in range(1, 9)), *(f"Figure {k}" for k in range(2, 16)),
              "Figure 16a", "Figure 16b", "Figure 17", *parts.suite_names()]
    for label in labels:
        _, target = cell(html, label)
        assert html.count(f'id="{target[1:]}"') == 1, label
    for target in re.findall(r'href="#([^"]+)"', html):
        assert html.count(f'id="{target}"') == 1, target


def test_cells_have_the_worst_verdict_of_what_was_written(html):
    assert cell(html, "Table 1")[0] == "deviates (open)"
    assert cell(html, "L-plate")[0] == "match"
    assert cell(html, "Table 2")[0] == "within tolerance"
    assert cell(html, "Table 3")[0] == "not run"
    assert cell(html, "Figure 2")[0] == "not reproducible"
    assert cell(html, "Figure 7")[0] == "not reproducible"
    assert cell(html, "Figure 3")[0] == "drawn"
    assert cell(html, "Figure 12")[0] == "not run"
    assert cell(html, "Figure 5")[0] == "deviates (explained)"
    assert cell(html, "kernel")[0] == "match"
    assert cell(html, "patch")[0] == "not run"
    assert cell(html, "mutants")[0] == "left out"
    assert html.count("not redrawn") == 3


def test_captions_say_what_is_drawn(html):
    """Mesh, step and end of the runs, where the case's data comes from, and the files."""
    said = {title: re.sub("<[^>]+>", "", made) for title, made in re.findall(
        r'<figcaption>([^<]+)\.\s*<span class="files">.*?<small class="made">(.*?)</small>', html,
        re.DOTALL)}
    data = "data of the case: 17 printed, 7 assumed, 2 selected; from "
    run = "30 elements, dt = 0.02 s, until 1.2 s; " + data
    assert said["Energies"] == run + "runs/l-plate-480.h5".replace("480", "30")
    study, = (text for title, text in said.items() if title.startswith("Error of the energy"))
    assert study == ("30 elements, dt = 0.01 s, until 1.2 s; " + data
                     + f"convergence/l-plate/{SIZE}/study.json")
    assert "; from corovec/benchmarks/" in said["Mesh, loads and their functions of time"]
    assert said["Total energy, mesh by mesh"].endswith("runs/l-plate-30.h5, "
                                                       "runs/l-plate-30.h5, runs/l-plate-30.h5")


def test_every_row_is_counted_once(html):
    """The slope, of Table 1 and Figure 5; the energy drift, of Figures 3 and 6; the ratios.  What
    is compared with the paper is counted apart, and three sentences say what became of it."""
    counts = {what: {name: int(count) for count, name in re.findall(r">(\d+) ([^<]+)<", total)}
              for what, total in re.findall('<p class="sum">Against ([^:]*):(.*?)</p>', html)}
    ratios = sum(cell.table == "Table 2" and cell.method == "dense" for cell in cells())
    assert counts["the paper"] == {"deviates (open)": 1, "deviates (explained)": 1, "match": 1,
                                   "within tolerance": ratios}
    own = counts["closed forms and finer results of our own"]
    assert own == {"match": 4, "within tolerance": 2}
    assert counts["what wrong or weaker variants must give"] == {"bound met": 1}
    said = re.search('<ul class="standing">(.*?)<p class="sum">', html, re.DOTALL)[1]
    for text in ("of energy and momenta: 3 rows: Figure 3 (3)",
                 f"of the paper's numbers and statements: {ratios + 1} rows: "
                 f"Table 2 ({ratios}), Figure 7 (1)", "<li><b>Figure 7</b> ",
                 "which proves little: 0 rows.",
                 "</b>: 2 rows: Table 1 (2); and the shapes of all curves"):
        assert text in said, text


def test_agreement_on_chosen_data_is_told_apart():
    """Each row of the paper where it is first, by what its verdict rests on."""
    def row(name, verdict, rests_on="", kind="published"):
        return {"name": name, "verdict": verdict, "rests_on": rests_on, "kind": kind}

    table = [row("a", "match"), row("b", "selected", "selected"), row("c", "match", "assumed"),
             row("d", "deviates (open)", "selected"), row("e", "match", kind="analytic")]
    figure = [{**table[0], "anchor": "elsewhere"}, row("f", "bound met", "", "statement"),
              row("g", "match", kind="analytic"), row("h", "deviates (open)", kind="analytic"),
              row("i", "bound met", kind="baseline")]
    assert tables.standing([("Table 9", table), ("Figure 9", figure)]) == [
        [("Figure 9", ["g"])], [("Table 9", ["a"]), ("Figure 9", ["f"])],
        [("Table 9", ["b", "c"])], [("Table 9", ["d"]), ("Figure 9", ["h"])]]


def test_cells_of_tables_say_how_far_apart(html):
    """The largest difference of an energy, and the range of the ratios of CPU times."""
    for label, said in (("Table 1", "energy, L-plate; up to 1.10% apart, more than the last "
                         "printed digit, 7.0e-4%"),
                        ("Table 2", "CPU time, L-plate; dense / skyline 1.1 times the paper's")):
        assert f"<b>{label}</b><small>{said.replace(chr(39), '&#39;')}</small>" in html
    assert tables.apart([]) == tables.ratio_apart([]) == ""
    near = {**DEVIATING, "difference": 5e-6, "verdict": "match"}
    assert tables.apart([near]) == "up to 5.0e-4% apart, within the last printed digit"


def test_first_screen_says_how_much_is_conserved(html):
    """Of each case, and where the paper has no figure of it; and what the exact scheme does."""
    said = re.search('<ul class="standing">(.*?)</ul>\n<p class="sum">', html, re.DOTALL)[1]
    assert re.search(r"L-plate: energy \S+, linear momentum \S+, angular momentum [^ ]+\.", said)
    assert ("drifts of 1 flight at most: energy 1.2e-13, linear momentum 1.0e-15, angular momentum "
            "1.0e-14; largest step that it holds (quasi): L-plate 0.020 or more s (– s)") in said
    energy, momentum = ({"name": f"{name} drift, 2 s", "value": value} for name, value in (
        ("energy", 2e-4), ("linear momentum", 1e-12)))
    assert tables.kept([energy, momentum, {**energy, "value": 1e-4}], {"energy"}) == (
        "energy 2.0e-4, linear momentum 1.0e-12 (in no figure of the paper)")
    assert tables.kept([], ()) == ""


@pytest.mark.slow
def test_one_number_has_one_verdict(tmp_path):
    """The level of Figures 3 and 6 is a row of the study, and so is its verdict."""
    level = {**DEVIATING, "name": "480 elements: energy after unloading [J]"}
    finish(tmp_path, "converge-l-plate", {**study(), "verdicts": [level]})
    html = page.build(SIZE, tmp_path).read_text(encoding="utf-8")
    for label in ("Table 1", "Figure 3", "Figure 6"):
        assert html.count(f">{level['name']}<") == 3  # the study's table, and both figures
        assert cell(html, label) == ("deviates (open)", "#l-plate-study-1"), label


def test_cells_lead_to_the_row_that_gave_their_verdict(html):
    for label in ("Table 1", "Table 2", "L-plate", "kernel", "Figure 5"):
        verdict, target = cell(html, label)
        row = re.search(rf'<tr id="{target[1:]}">(.*?)</tr>', html)[1]
        assert f">{verdict}<" in row, label


def schemes(**paths):
    """A study of conservation: a flight of the exact scheme, and one that quasi lost."""
    flight = {"case": "l-plate", "elements": 30, "scheme": "exact", "dt": 0.02, "end_time": 4.0,
              "reached": 4.0, "holds": True, "error": "", "energy_drift": 1.25e-13,
              "linear_momentum_drift": 1e-15, "angular_momentum_drift": 1e-14,
              "energy_change": 0.0, "energy_rise": 0.0, "iterations_per_step": 9.0, "halvings": 0,
              "halved_share": 0.0, "cpu_per_second": 0.1, "path_error": paths.get("exact")}
    lost = {**flight, "scheme": "quasi", "reached": 1.5, "holds": False, "energy_drift": 2.5e-5,
            "cpu_per_second": None, "path_error": None}
    largest = {**flight, "largest_step": 0.02, "of_paper": 200.0, "larger_untried": True}
    none = {**dict.fromkeys(largest), "case": "l-plate", "scheme": "quasi", "larger_untried": False}
    drift = {"case": "l-plate", "dt": 0.02}
    return {"flights": [flight, lost], "schemes": [largest, none],
            "energy": [{**drift, "scheme": name, "time": time, "energy_drift": value}
                       for name, value in (("exact", 0.0), ("quasi", 1e-5)) for time in (1.0, 2.0)],
            "verdicts": [{**DEVIATING, "case": "l-plate", "name": "exact: energy",
                          "kind": "analytic", "verdict": "match"}],
            "origin": {"commit": "new", "size": SIZE, **WRITTEN}}


def test_schemes_side_by_side(html):
    """Flights and what is held, the picture of what there are numbers for, verdicts."""
    assert cell(html, "schemes") == ("match", "#conservation-1")
    section = html.partition('<section id="conservation">')[2].partition("</section>")[0]
    for text in ("0.0200+", "1.2e-13", "1.500 of 4", "L-plate: dt = 0.02 s",
                 "l-plate, exact: energy", "figures/energy-drift.svg",
                 f"conservation/{SIZE}/study.json"):
        assert text in section, text
    assert "work-precision" not in section


def test_paths_are_drawn_where_they_are_compared(tmp_path):
    drawn = tmp_path / "page" / "figures" / "work-precision.csv"
    drawn.parent.mkdir(parents=True)
    for contents in (schemes(exact=1e-3), schemes()):
        finish(tmp_path, "conserve", contents)
        shown = page._schemes(Results(SIZE, tmp_path), SIZE, tmp_path)
        compared = contents["flights"][0]["path_error"] is not None
        assert drawn.exists() == compared == ("work-precision" in [
            drawing.name for drawing in shown.drawings])


def test_a_finding_says_what_lacks_of_its_evidence(html):
    shown = html.partition("Checks that are known to fail")[2].partition("</article>")[0]
    assert "left out" in shown and "no evidence" in shown
    shown = html.partition("The symmetric matrix of a step")[2].partition("</article>")[0]
    assert "no evidence" not in shown


def digits(text):
    """(number, unit of its last digit, significant digits) of a text of the page."""
    text = text.removeprefix("≥ ").partition(" ")[0]
    mantissa, _, exponent = text.rstrip("%").partition("e")
    unit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    unit *= 0.01 if text.endswith("%") else 1.0
    count = len(mantissa.lstrip("+-0.").replace(".", ""))
    return float(mantissa) * 10.0 ** int(exponent or 0) * (
        0.01 if text.endswith("%") else 1.0), unit, count


def random_rows(rng, count):
    """Rows of numbers of all sizes."""
    def some():
        return float(rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-18, 6))

    return [Row(f"row {k}", some(), some(), "analytic", abs(some()), "",
                scale=rng.choice([1.0, None])).as_dict() for k in range(count)]


@pytest.mark.slow
def test_numbers_of_the_page_are_those_of_its_files(tmp_path):
    """Two hundred of them, by chance, to the digits shown, of which a float has two at least."""
    rng = np.random.default_rng(20)
    report = suite("kernel")
    for case in report["cases"]:
        case["rows"] = random_rows(rng, 30)
    finish(tmp_path, "verify-kernel", report)
    found = {**study(), "verdicts": random_rows(rng, 30), "summary": study()["summary"] + [
        {"quantity": f"quantity {k}", "unit": "J" if k % 2 else "", "note": "", "printed": "",
         **{name: float(10.0 ** rng.uniform(-18, 6))
            for name in ("ours", "of_printed", "of_all_printed")}} for k in range(30)]}
    finish(tmp_path, "converge-l-plate", found)
    html = page.build(SIZE, tmp_path).read_text(encoding="utf-8")
    sources = {f"case-{case['name']}-{k}": row for case in report["cases"]
               for k, row in enumerate(case["rows"], 1)}
    sources |= {f"l-plate-study-{k}": row for k, row in enumerate(found["verdicts"], 1)}
    pairs = []
    for anchor, row in sources.items():
        shown = re.findall("<td[^>]*>(.*?)</td>", re.search(
            f'<tr id="{anchor}">(.*?)</tr>', html)[1])
        pairs += zip((shown[2], shown[3], shown[5], shown[6]), (
            row["value"], row["reference"], row["difference"], row["tolerance"]))
    for row in found["summary"][1:]:
        shown = re.search(rf">{row['quantity']}(?: \[J\])?</td>(.*?)</tr>", html)[1]
        pairs += zip(re.findall("<td[^>]*>(.*?)</td>", shown), (
            row["ours"], row["of_printed"], row["of_all_printed"]))
    for k in rng.choice(len(pairs), 200, replace=False):
        text, value = pairs[k]
        number, unit, count = digits(text)
        assert abs(number - value) <= 0.5 * unit * (1.0 + 1e-6) + 1e-12 * abs(value), pairs[k]
        assert count >= 2 or number == value, pairs[k]


@pytest.mark.slow
def test_what_did_not_finish_has_no_verdict_but_that(tmp_path, monkeypatch):
    """Whatever file is there: of a part that failed, was interrupted, is damaged or outdated."""
    finish(tmp_path, "converge-l-plate", study(), "failed")
    finish(tmp_path, "time-table-2", timing(), "failed")
    broken = {"status": "failed", "error": "no convergence at t = 1 s"}
    finish(tmp_path, "converge-ruler", {**study(), "runs": [{**study()["runs"][0], **broken}]})
    damaged = finish(tmp_path, "converge-hemisphere", study()).result
    damaged.write_text(damaged.read_text()[:-9])
    missing = finish(tmp_path, "run-ruler-120").result
    changed = finish(tmp_path, "converge-plates", study()).result
    changed.write_text("[]", encoding="utf-8")
    finish(tmp_path, "verify-kernel", suite("kernel"), "begun")
    finish(tmp_path, "verify-patch", {**suite("patch"), "complete": False})
    finish(tmp_path, "verify-rotations", suite("rotations"))
    with monkeypatch.context() as earlier:
        earlier.setattr(parts, "code_version", lambda *_: "0.1.0+earlier")
        finish(tmp_path, "verify-linear", suite("linear"))
        finish(tmp_path, "verify-mutants", suite("mutants"))
    html = page.build(SIZE, tmp_path).read_text(encoding="utf-8")
    for verdict, labels in {
            "failed": ("Table 1", "Table 2", "L-plate", "Figure 5", "Table 5", "Table 7",
                       "Figure 12", "patch", "ruler", "Figure 8", "Figure 3", "Figure 11"),
            "not run": ("Table 6", "Figure 4", "kernel", "linear", "dynamics"),
            "left out": ("mutants",), "match": ("rotations",),
            "not reproducible": ("Figure 7",)}.items():
        assert {label: cell(html, label)[0] for label in labels} == dict.fromkeys(labels, verdict)
    for text in (f"{damaged} is missing or damaged", f"{changed} is missing or damaged",
                 str(missing), broken["error"],
                 "disk &lt;full&gt;", "verify-linear: finished, earlier sources",
                 "verify-kernel: begun", "finished, damaged", "time-growth: left out"):
        assert text in html, text


@pytest.mark.parametrize("name, data, others", [
    ("run-ruler-120", [solver, benchmarks], [verification]),
    ("converge-ruler", [solver, benchmarks, convergence, verification], [timing_package]),
    ("claims-ruler", [solver, benchmarks, convergence, verification], [timing_package]),
    ("conserve", [solver, benchmarks, convergence, verification], [timing_package]),
    ("time-table-4", [solver, benchmarks, timing_package, verification], [convergence]),
    ("verify-patch", [solver, benchmarks, verification], [convergence])])
def test_stamps_see_code_and_data(tmp_path, monkeypatch, name, data, others):
    """A part is out of date when code, TOML or JSON changes that it computes with or judges by."""
    part = Results(SIZE, tmp_path).parts[name]
    monkeypatch.setattr(parts, "code_version", code_version.__wrapped__)
    for package in (*data, *others):
        for file in ("module.py", "printed.toml", "data.json"):
            folder = tmp_path / package.__name__
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            (folder / file).write_text("1")
            with monkeypatch.context() as moved:
                moved.setattr(package, "__file__", str(folder / "__init__.py"))
                before = part.code
                (folder / file).write_text("2")
                assert (part.code != before) == (package in data), (package, file)


def test_results_may_be_moved(tmp_path):
    for name in ("converge-l-plate", "time-table-2"):
        finish(tmp_path / "here", name, study())
        shutil.copytree(tmp_path / "here", tmp_path / "there", dirs_exist_ok=True)
        assert Results(SIZE, tmp_path / "there").read(name) == (study(), [])


def test_findings_are_shown_by_cases_that_their_commands_run():
    with open(page.FINDINGS, "rb") as file:
        findings = [finding for group in tomllib.load(file).values()
                    for finding in group["finding"]]
    for finding in findings:
        assert {"title", "text", "command"} <= set(finding)
        assert set(finding) <= {"title", "text", "command", "where", "cases", "rows"}, finding
        names = finding["command"].partition(" && ")[0].split()[2:]
        if "cases" in finding:
            assert set(finding["cases"]) <= {case.name for case in find(names)}, finding["title"]


def test_rounds_of_every_timing_are_shown(html):
    """Least, lower quartile, median, upper quartile, how many: 1, 1.125, 1.25, 1.375, 3."""
    cells = "".join(f'<td class="n">{text}</td>' for text in ("1", "1.12", "1.25", "1.38", "3"))
    assert html.count(cells) == 3 * len(METHODS)
    (target,) = tables.targets({"tables": {
        "D": [{"unknowns": 2, **Sample((0.1,), (0.1,)).row("D")}],
        "targets": [Target("a", "D", 4.0, 3.0, (2.0, 1.0, 4.0)).row()]}}).rows
    assert target[5:10] == ["1", "1.50", "2", "3", "3"]
    (phase,) = tables.phases({"tables": {"growth-phases": [
        {"case": "plates", "elements": 432, "method": "auto", "phase": "step",
         **Sample((2.0, 1.0, 4.0), (1.0,)).row("call")}]}}).rows
    assert phase[4:] == target[5:10]


@pytest.mark.slow
def test_what_moved_since_the_last_record_is_shown(tmp_path, html):
    """Both numbers, both commits, what fell; without a record, that there is none."""
    assert "</a>: no earlier record." in html
    finish(tmp_path, "converge-l-plate", study())
    before = study()
    before["origin"].update(commit="old", date="2026-01-01")
    before["mesh"][0]["energy"] = before["verdicts"][0]["value"] = 70.5
    before["verdicts"][2]["verdict"] = "match"
    keep(tmp_path, records_of([(tmp_path, before)]))
    (tmp_path / "records" / "bad.json").write_text("{", encoding="utf-8")
    shown = page.build(SIZE, tmp_path).read_text(encoding="utf-8")
    assert "</a>: old -&gt; new, 3 compared: 1 verdict fell, 1 number moved; first" in shown
    assert "record bad.json is damaged and skipped" in shown
    moved = shown.partition('id="changes"')[2].partition("</section>")[0]
    for text in ("slope", "deviates (explained)", "70.5", "70.6", "old", "new", "fell"):
        assert text in moved


def test_printed_numbers_errata_and_provenance_are_shown(html):
    for text in ("71.373", "13,460 s†", "13,460 s read as 13.460 s", "10,436.720 s", "2,005,032 s*",
                 'class="badge assumed"', 'class="badge calibrated"', "disk &lt;full&gt;"):
        assert text in html, text


@pytest.mark.parametrize("row, shown, tolerance", [
    ({"value": 1.1, "reference": 1.0, "scale": None}, "+10.000%", "1.000%"),
    ({"value": 5.0, "reference": 3.0, "scale": 1.0}, "+2", "0.010"),
    ({"value": 2e-6, "reference": 0.0, "scale": None}, "+2.0e-6", "0.010"),
    ({"value": 1.0, "reference": 3.0, "scale": 5.0}, "-40.000% of 5", "1.000% of 5")])
def test_differences_say_what_they_are_relative_to(row, shown, tolerance):
    """To the reference, to a scale that is named, or to nothing."""
    row = Row("a", kind="published", tolerance=0.01, reason="", **row).as_dict()
    assert tables.difference(row) == shown
    assert tables.amount(row, row["tolerance"]) == tolerance


@pytest.mark.parametrize("value, shown", [
    (0.02586, "2.586%"), (1.2e-4, "0.012%"), (4.23e-6, "4.2e-4%"), (-4.23e-6, "-4.2e-4%"),
    (1.362e-15, "1.4e-13%"), (0.0, "0.000%"), (-0.0, "0.000%"), (None, "–")])
def test_percentages_have_two_digits(value, shown):
    assert tables.percent(value) == shown
    signed = "+" * bool(value and value > 0.0) + shown
    assert tables.percent(value, sign=True) == signed


@pytest.mark.parametrize("damage", ['{"seconds": "many"}', '{"seconds": 1.0}', "[]", "no"])
def test_a_stamp_that_is_none_counts_as_not_run(tmp_path, damage):
    part = finish(tmp_path, "verify-patch", suite("patch"))
    stamps = Stamps(tmp_path / "parts")
    whole = stamps.read(part)
    text = damage if damage[0] != "{" else json.dumps(
        {**json.loads(damage), **{k: v for k, v in whole.items() if k not in (
            "seconds", "status")}})
    (tmp_path / "parts" / "verify-patch.json").write_text(text)
    assert stamps.read(part) is None


@pytest.mark.slow
def test_pictures_of_lost_results_do_not_stay(tmp_path):
    """Those of an earlier page, of parts that are not finished any more."""
    figures = tmp_path / "page" / "figures"
    figures.mkdir(parents=True)
    for name in ("figure-04.svg", "figure-04.csv"):
        (figures / name).write_text("old")
    page.build(SIZE, tmp_path)
    assert not list(figures.glob("figure-04*")) and (figures / "figure-02.svg").exists()


@pytest.mark.slow
def test_cases_are_drawn_in_processes(tmp_path):
    """The same page as by one process, but for its date."""
    shown = [re.sub(r"\d{4}-\d\d-\d\d \d\d:\d\d", "", page.build(
        SIZE, tmp_path, jobs).read_text(encoding="utf-8")) for jobs in (1, 2)]
    assert shown[0] == shown[1]


def test_list_writes_nothing(tmp_path):
    result = CliRunner().invoke(command, ["--list", "--output", str(tmp_path / "new")])
    assert result.exit_code == 0 and "converge-plates" in result.output
    assert list(tmp_path.iterdir()) == []


def test_page_without_results_is_whole(tmp_path):
    """Meshes are drawn, everything else is not run, and nothing is missing silently."""
    html = page.build(SIZE, tmp_path).read_text(encoding="utf-8")
    assert html.count("<img") == 4
    assert cell(html, "Table 1")[0] == cell(html, "Figure 3")[0] == "not run"
    assert cell(html, "mutants")[0] == "left out"
    assert "Plotly" not in html
    said = re.sub("<.*?>", "", re.search('<ul class="standing">(.*?)</ul>', html, re.DOTALL)[1])
    assert "L-plate 7 assumed, 2 selected; ruler" in " ".join(said.split())


def test_pictures_lie_beside_the_page_with_their_data(results, html):
    files = re.findall(r'href="(figures/[^"]+)"', html)
    assert len(files) >= 3 * 9
    assert all((results / "page" / name).stat().st_size > 0 for name in files if name)


def test_player_holds_the_frames(results):
    recording = Recording.open(parts.run_file(results, "l-plate", 30))
    data = player(recording)
    assert data["frames"] == FRAMES and data["elements"] == 30
    scaled = np.frombuffer(gzip.decompress(b64decode(data["position"])), "<u2")
    x = scaled.reshape(FRAMES, -1, 3) / STEPS * data["size"] + data["low"]
    x += np.transpose(data["centre"])[:, None]
    assert np.abs(x - recording.positions()).max() < 2e-4
    energy = np.array(data["kinetic"]) + data["strain"]
    assert np.abs(energy[50:] / energy[50] - 1.0).max() < 1e-3


@pytest.mark.parametrize("complete", [True, False])
def test_suite_that_breaks_off_is_no_deviation(tmp_path, monkeypatch, complete):
    """Both end with exit status 1; the file of the suite tells them apart."""
    path = tmp_path / "suite.json"

    def execute(*_):
        path.write_text(json.dumps({**suite("kernel"), "complete": complete}))
        return 1

    monkeypatch.setattr(reproduce, "execute", execute)
    part = Part("verify-kernel", "verify", ("verify", "kernel"), path, ())
    assert reproduce.run_parts([part], tmp_path, 1) == (not complete)


def test_claims_follow_their_runs(tmp_path, monkeypatch):
    """They are run last, with the files of the runs that are finished, and again when one changes;
    without a finished run what they wrote is not shown."""
    (claims,) = parts.select(parts.parts(SIZE, tmp_path), ["claims-l-plate"])
    runs, ran = list(claims.inputs), []

    def execute(command, log):
        name, path = command[0], Path(command[command.index("--output") + 1])
        ran.append([Path(word).stem for word in command[1:] if word.endswith(".h5")])
        path.write_text(json.dumps({"figures": {}, "run": len(ran)}), encoding="utf-8")
        return int(name == "run" and path.stem == "l-plate-480")

    monkeypatch.setattr(reproduce, "execute", execute)
    assert [part.name for part in runs] == [f"run-l-plate-{n}" for n in (30, 120, 480)]
    assert reproduce.run_parts([*runs, claims], tmp_path, 1) == 1
    assert len(ran) == 4 and ran[-1] == ["l-plate-30", "l-plate-120"]
    assert Results(SIZE, tmp_path).read(claims.name)[0]["run"] == 4
    stamps = Stamps(tmp_path / "parts")
    assert stamps.finished(claims)
    finish(tmp_path, "run-l-plate-480")
    assert not stamps.finished(claims)
    assert parts.status(claims, stamps) == "finished, earlier sources or runs"
    assert Results(SIZE, tmp_path).read(claims.name)[0] is None
    assert reproduce.run_parts([claims], tmp_path, 1) == 0
    assert ran[-1] == ["l-plate-30", "l-plate-120", "l-plate-480"] and stamps.finished(claims)


def test_every_figure_that_claims_something_is_on_the_page():
    """And what it claims is known; figures of a study have no claims of their own."""
    for case, shown in drawings.benchmarks().items():
        claimed = claims.claims(case, {})
        studied = {label for label, (figure, _) in shown.verdicts.items() if figure.of_study}
        assert set(claimed) == set(shown.verdicts) - studied


@pytest.mark.slow
def test_failed_part_does_not_stop_the_others(tmp_path, capfd):
    suite = parts.suite_file(tmp_path, "good")
    good = Part("verify-good", "verify", ("verify", "rigid-momenta", "--output", str(suite),
                                          "--overwrite"), suite, ())
    bad = replace(good, name="verify-bad", command=("verify", "no-such-case"))
    said = []
    assert reproduce.run_parts([bad, good], tmp_path, 1, said.append) == 1
    stamps = Stamps(tmp_path / "parts")
    assert "no-such-case" in stamps.read(bad)["message"]
    assert stamps.finished(good) and not stamps.finished(bad)
    assert parts.status(bad, stamps) == "failed"
    assert reproduce.run_parts([good], tmp_path, 1, said.append) == 0
    assert said[-1] == "1 of 1 parts are there already"


@pytest.mark.slow
def test_parts_end_as_commands_do(tmp_path, monkeypatch, capfd):
    """With the same exit status; what they say is in their logs, and nowhere else; also where they
    are spawned, for want of a server that forks."""
    log = tmp_path / "log"
    for words, status, said in ((("list",), 0, "l-plate"), (("verify", "no-such-case"), 2, (
            "corovec: error: 'no-such-case' is neither")), (("--no-such-option",), 2, "No such")):
        assert reproduce.execute(words, log) == status
        assert said in log.read_text()
    monkeypatch.setattr(processes.multiprocessing, "get_all_start_methods", lambda: ["spawn"])
    assert reproduce.execute(("verify", "no-such-case"), log) == 2
    assert "corovec: error: 'no-such-case' is neither" in log.read_text()
    assert capfd.readouterr() == ("", "")


@pytest.mark.slow
def test_threads_start_parts_at_once(tmp_path):
    with ThreadPoolExecutor(8) as pool:
        ended = pool.map(lambda k: reproduce.execute(("info", str(k)), tmp_path / f"{k}.log"),
                         range(24))
    assert list(ended) == [2] * 24


def test_longest_parts_begin_first(tmp_path, monkeypatch):
    """After the timings, before the others, which stay in order."""
    begun, everything = [], parts.select(parts.parts(SIZE, tmp_path), [])
    monkeypatch.setattr(reproduce, "execute", lambda command, log: begun.append(log.stem) or 1)
    reproduce.run_parts(everything, tmp_path, 1)
    timings = [part.name for part in everything if part.alone]
    assert begun[:len(timings)] == timings
    longest = [name for name in parts.LONGEST if name != "verify-mutants"]  # left out
    others = [part.name for part in sorted(everything, key=lambda part: bool(part.inputs))
              if not part.alone and part.name not in longest]
    assert begun[len(timings):] == longest + others


def test_interrupted_run_goes_on(tmp_path):
    """A run that stopped half way is resumed, not begun again; other sources begin again."""
    path = parts.run_file(tmp_path, "l-plate", 30)
    path.parent.mkdir()
    options = ("run", "l-plate", "--elements", "30", "--dt", "0.02", "--end-time", "1.2",
               "--frame-every", "20")
    part = Part("run-l-plate-30", "run", (*options, "--output", str(path)), path, ())

    class Stop(Exception):
        pass

    def stop(step, *_):
        if step == 45:
            raise Stop

    with pytest.raises(Stop):
        simulate(load_case("l-plate").model(30), Settings(dt=0.02, end_time=1.2, frame_every=20),
                 output=path, case="l-plate", progress=stop, probes={"S": (10.0, 7.0, 0.0)})
    (tmp_path / "parts").mkdir()
    stamps = Stamps(tmp_path / "parts")
    stamps.write(part, "begun")
    assert reproduce.run_parts([part], tmp_path, 1) == 0
    assert Recording.open(path).contents["step"] == 60
    assert stamps.finished(part)
    other = replace(part, command=(*part.command, "--rho-inf", "0.9"))
    assert not stamps.finished(other)


def test_wrong_input_is_one_line():
    with pytest.raises(InputError, match="size 'huge' is unknown"):
        parts.parts("huge", Path("x"))
    with pytest.raises(InputError, match="part 'nonsense' is unknown"):
        parts.select(parts.parts(SIZE, Path("x")), ["nonsense"])
    with pytest.raises(InputError, match="jobs must be at least 1"):
        CliRunner().invoke(command, ["--jobs", "0"], standalone_mode=False, catch_exceptions=False)


def test_plan_names_meshes_and_frames_of_the_figures():
    """Every run is possible, and its frames fall on the instants of the motion sequences."""
    intervals = {name: drawing.options["end"] / drawing.options["intervals"]
                 for name, shown in drawings.benchmarks().items() for figure in shown.figures
                 for drawing in figure.drawings if drawing.kind == "motion"}
    for size in parts.SIZES:
        for case, runs in parts.plan(size).items():
            for run in runs:
                assert run["elements"] in load_case(case).sizes
                settings = Settings(run["dt"], run["end_time"], frame_every=run["frame_every"])
                between = intervals[case] / (settings.dt * settings.frame_every)
                assert between == pytest.approx(round(between)) and between > 0.5


def chromium(playwright):
    """A Chromium: the one that playwright installed, or the system's."""
    found = [playwright.chromium.executable_path, *map(shutil.which, (
        "chromium", "chromium-browser", "google-chrome"))]
    path = next((path for path in found if path and Path(path).exists()), None)
    if path is None:
        pytest.fail("no Chromium: playwright install chromium, or the system's package chromium")
    return playwright.chromium.launch(executable_path=path, args=[
        "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"])


@pytest.fixture(scope="module")
def browser():
    if os.environ.get("COROVEC_BROWSER") != "required":
        pytest.skip("tox -e page runs it: a minute and a half")
    sync_api = pytest.importorskip("playwright.sync_api")
    with sync_api.sync_playwright() as playwright:
        running = chromium(playwright)
        yield running
        running.close()


WHOLE = """() => [document.documentElement.scrollWidth <= innerWidth,
    [...document.images].filter(i => !(i.complete && i.naturalWidth > 100)).map(i => i.alt),
    [...document.querySelectorAll("body *")].filter(
        e => !e.closest(".scroll, .picture, nav, .stage")
        && e.getBoundingClientRect().right > innerWidth + 1).map(e => e.className || e.tagName)]"""


IN_SIGHT = """target => {
    const box = document.querySelector(target).getBoundingClientRect();
    const bar = document.querySelector("nav").getBoundingClientRect();
    return box.height > 0 && box.top >= bar.bottom - 1 && box.top < innerHeight - 20; }"""


@pytest.mark.parametrize("width", [390, 1440])
def test_whole_in_a_browser(browser, results, html, width):
    """No error, no image missing, nothing beyond the edge, nothing fetched; the player plays."""
    tab, said, fetched = browser.new_page(viewport={"width": width, "height": 900}), [], []
    tab.on("console", lambda message: said.append(message.text) if message.type == "error" else 0)
    tab.on("pageerror", lambda error: said.append(str(error)))
    tab.on("request", lambda request: fetched.append(request.url))
    tab.goto((results / "page" / "index.html").as_uri())
    assert tab.evaluate(WHOLE) == [True, [], []]
    root = tab.locator(".player").first
    root.scroll_into_view_if_needed()
    tab.wait_for_selector(".player.ready", timeout=120_000)
    stage = root.locator(".stage")
    before = stage.get_attribute("data-frame"), stage.screenshot()
    root.locator(".play").click()
    tab.wait_for_function("() => Number(document.querySelector('.stage').dataset.frame) > 5",
                          timeout=120_000)
    root.locator(".play").click()
    after = stage.get_attribute("data-frame"), stage.screenshot()
    assert before[0] == "0" and before[1] != after[1]
    root.locator(".time").fill(str(FRAMES - 1))
    tab.wait_for_function(f"() => document.querySelector('.stage').dataset.frame == {FRAMES - 1}")
    assert float(root.locator(".energies .total b").inner_text()) == pytest.approx(70.64, abs=0.1)
    assert tab.evaluate(WHOLE)[0]
    assert not said
    assert all(url.startswith(("file:", "data:", "blob:")) for url in fetched)
    tab.close()


@pytest.mark.parametrize("width", [390, 1280])
def test_what_a_cell_leads_to_is_in_sight(browser, results, html, width):
    """For every cell: also where it lies in something folded, is folded again, or was there
    already; below the bar of sections that stays at the top."""
    tab = browser.new_page(viewport={"width": width, "height": 800})
    tab.goto((results / "page" / "index.html").as_uri())
    cells = tab.locator("a.cell")
    assert not tab.locator(cell(html, "kernel")[1]).is_visible()
    for k in [*range(cells.count()), cells.count() - 1]:
        target = cells.nth(k).get_attribute("href")
        tab.evaluate("""() => {
            document.querySelectorAll("details").forEach(each => each.open = false);
            scrollTo(0, 0); }""")
        cells.nth(k).click()
        assert tab.evaluate(IN_SIGHT, target), target
    tab.close()


OVERFLOWING = """() => [...document.querySelectorAll(".scroll")].filter(
    box => box.scrollWidth > box.clientWidth).map(box => box.innerText.slice(0, 40))"""

VERDICTS = """() => [...document.querySelectorAll("th")].filter(
    head => head.innerText === "verdict" || head.innerText === "met").map(head => head.cellIndex)"""


@pytest.mark.parametrize("width, cut", [(1280, 0), (390, 1)])
def test_tables_and_figures_fit(browser, results, html, width, cut):
    """Folded ones too: none is cut on a desk; on a phone only numbers that stand in columns are,
    verdicts come first and figures are as wide as the screen, each a link to its file."""
    tab = browser.new_page(viewport={"width": width, "height": 800})
    tab.goto((results / "page" / "index.html").as_uri())
    tab.evaluate("document.querySelectorAll('details').forEach(each => each.open = true)")
    assert tab.evaluate("document.documentElement.scrollWidth") == width
    assert all("solver" in text for text in tab.evaluate(OVERFLOWING))
    assert bool(tab.evaluate(OVERFLOWING)) == cut
    assert set(tab.evaluate(VERDICTS)) == {0}
    for image in tab.locator(".picture img").all():
        box = image.bounding_box()
        assert 0 <= box["x"] and box["x"] + box["width"] <= width
        assert (results / "page" / image.locator("..").get_attribute("href")).exists()
    tab.close()


def test_print(browser, results, html):
    """Tables and figures with a list of contents, within the width of paper; nothing folded."""
    tab = browser.new_page(viewport={"width": 695, "height": 1000})
    tab.emulate_media(media="print")
    tab.goto((results / "page" / "index.html").as_uri())
    assert tab.get_by_text("Contents", exact=True).is_visible()
    assert tab.get_by_text("ended with an error").is_visible()
    for hidden in ("nav", "#parts", ".player", "details:not(.legend)"):
        assert not tab.locator(hidden).first.is_visible(), hidden
    assert tab.evaluate("document.documentElement.scrollWidth") <= 695
    pages = len(re.findall(rb"/Type /Page\b", tab.pdf(prefer_css_page_size=True)))
    assert 5 <= pages <= 25
    tab.close()


CAMERA = """() => {
    const {eye, up} = document.querySelector(".stage")._fullLayout.scene._scene.getCamera();
    return [eye.x, eye.y, eye.z, up.x, up.y, up.z]; }"""

SIZE_SEEN = "() => document.querySelector('.stage')._fullLayout.scene.aspectratio.x"


def test_player_zooms_and_keeps_its_camera(browser, results, html):
    """Keys play and step, buttons and the wheel zoom; what was turned stays so while it plays and
    follows or not, until the start is asked for again."""
    tab = browser.new_page(viewport={"width": 1280, "height": 900})
    tab.goto((results / "page" / "index.html").as_uri())
    root = tab.locator(".player").first
    root.scroll_into_view_if_needed()
    tab.wait_for_selector(".player.ready", timeout=120_000)
    stage = root.locator(".stage")
    start, size = tab.evaluate(CAMERA), tab.evaluate(SIZE_SEEN)
    recording = Recording.open(parts.run_file(results, "l-plate", 30))
    eye = np.array(player(recording)["eye"])
    assert np.allclose(start[:3] / np.linalg.norm(start[:3]), eye, atol=1e-5)

    def frame(k):
        tab.wait_for_function(f"() => document.querySelector('.stage').dataset.frame == {k}")

    def zoomed(ratio):
        tab.wait_for_function(f"() => Math.abs(({SIZE_SEEN})() / {size} - {ratio}) < 1e-3")

    root.focus()
    for key, k in (("ArrowRight", 1), ("ArrowRight", 2), ("ArrowLeft", 1)):
        root.press(key)
        frame(k)
    root.press("Space")
    tab.wait_for_function("() => document.querySelector('.stage').dataset.frame > 3",
                          timeout=120_000)
    root.press("Space")
    root.locator(".nearer").click()
    zoomed(1.3)
    root.locator(".farther").click()
    zoomed(1.0)
    box = stage.bounding_box()
    tab.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 0.5 * box["height"])
    tab.wait_for_timeout(400)
    tab.mouse.wheel(0, -200)
    zoomed(np.exp(0.3))
    tab.mouse.down()
    tab.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 0.3 * box["height"], steps=4)
    tab.mouse.up()
    turned = tab.evaluate(CAMERA)
    assert not np.allclose(turned, start, atol=0.1)
    root.locator(".play").click()
    tab.wait_for_function("() => document.querySelector('.stage').dataset.frame > 9",
                          timeout=120_000)
    root.locator(".play").click()
    assert np.allclose(tab.evaluate(CAMERA), turned, atol=1e-6)
    zoomed(np.exp(0.3))
    for _ in range(2):
        root.locator(".follow").click()
        tab.wait_for_timeout(300)
        assert np.allclose(tab.evaluate(CAMERA), turned, atol=1e-6)
    zoomed(np.exp(0.3))
    fingers = tab.context.new_cdp_session(tab)
    at = {"y": box["y"] + 0.5 * box["height"]}
    for kind, apart in (("touchStart", 50), ("touchMove", 60), ("touchMove", 75)):
        fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [
            {"x": box["x"] + 300 + side * apart, "id": k, **at} for k, side in enumerate((-1, 1))]})
    fingers.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    zoomed(1.5 * np.exp(0.3))
    assert np.allclose(tab.evaluate(CAMERA), turned, atol=1e-6)
    root.locator(".whole").click()
    zoomed(1.0)
    assert np.allclose(tab.evaluate(CAMERA), start, atol=1e-6)
    tab.close()


def test_readable_without_javascript(browser, results, html):
    context = browser.new_context(java_script_enabled=False)
    tab = context.new_page()
    tab.goto((results / "page" / "index.html").as_uri())
    assert tab.locator("img").count() == html.count("<img")
    assert tab.get_by_text("71.373").first.is_visible()
    assert not tab.locator(".player").first.is_visible()
    context.close()
