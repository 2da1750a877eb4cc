"""Commands ``corovec converge``, ``conserve``, ``claims`` and ``calibrate``."""

import json
import sys
from contextlib import nullcontext

import click

from corovec.solver.names import printable


@click.command()
@click.argument("cases", metavar="[CASE]...", nargs=-1)
@click.option("--size", default="quick", show_default=True,
              help="quick (the coarse meshes), full (all meshes, the paper's simulated time) or "
                   "paper (its time step as well: days).")
@click.option("--jobs", type=int, help="Worker processes.  Default: one a usable core.")
@click.option("--scheduler", metavar="ADDRESS",
              help="Dask scheduler that executes the runs, as tcp://host:8786; needs the extra "
                   "[cluster], and the same corovec on its workers (--nthreads 1).")
@click.option("--membrane", default="stress", show_default=True,
              help="Assumed membrane field: stress, strain, or compatible (none).")
@click.option("-o", "--output", type=click.Path(file_okay=False), default="results/convergence",
              show_default=True, help="Folder of the tables (CASE/SIZE) and of the finished runs.")
@click.option("--json", "as_json", is_flag=True, help="Print the tables as one JSON object.")
def converge(cases, size, jobs, scheduler, membrane, output, as_json):
    """Convergence studies of CASEs (default: all) beside the paper's tables.

    Energy after unloading mesh by mesh; whether the time step matters beside the mesh; drift of
    energy and momenta, and its order; dissipation with rho_inf < 1.  Finished runs are kept and
    not run again, interrupted ones go on.  Exit status 1 if a run failed or a promise of the scheme
    is not kept without an explanation; a printed number that deviates is a finding.

    \b
    Examples:
      corovec converge l-plate
      corovec converge --size full --jobs 2
      corovec converge l-plate --size paper --scheduler tcp://127.0.0.1:8786
      corovec converge l-plate --membrane strain --json
    """
    from corovec import InputError
    from corovec.benchmarks import case_names
    from corovec.solver.results.files import writable_folder
    from corovec.solver.runtime.execution import dask_workers, processes

    from .campaign import Campaign
    from .report import show
    from .study import CaseStudy, run_studies
    from .tables import as_json as to_json
    from .tables import keeps_promises, origin, study_tables, write_tables

    if scheduler is not None and jobs is not None:
        raise InputError("--jobs and --scheduler exclude each other")
    place = nullcontext(processes(jobs)) if scheduler is None else dask_workers(scheduler)
    studies = [CaseStudy(case, size, membrane) for case in dict.fromkeys(cases or case_names())]
    folder = writable_folder(output)
    own = {study.case: writable_folder(folder / study.case / size) for study in studies}
    with place as workers, Campaign(folder / "runs", workers, notify=_tell) as campaign:
        outcomes = run_studies(studies, campaign)
    whence, reports, good = origin(studies, outcomes), {}, True
    for study in studies:
        tables = study_tables(study, outcomes)
        write_tables(own[study.case], tables, whence)
        reports[study.case] = to_json(tables, whence)
        good &= keeps_promises(tables["verdicts"])
        good &= "failed" not in set(tables["runs"]["status"])
        if not as_json:
            show(study, tables, own[study.case])
    if as_json:
        click.echo(json.dumps(reports))
    if not good:
        sys.exit(1)


@click.command()
@click.argument("cases", metavar="[CASE]...", nargs=-1)
@click.option("--size", default="quick", show_default=True,
              help="quick (seconds of flight) or full (the paper's simulated time: hours).")
@click.option("--jobs", type=int, help="Worker processes.  Default: one a usable core.")
@click.option("-o", "--output", type=click.Path(file_okay=False), default="results/conservation",
              show_default=True, help="Folder of the tables (SIZE) and of the finished runs.")
@click.option("--json", "as_json", is_flag=True, help="Print the tables as one JSON object.")
def conserve(cases, size, jobs, output, as_json):
    """Which scheme conserves what in free flight, up to which time step, and at what cost.

    CASEs (default: all) with the paper's scheme, the same with axes that follow the nodes, the
    exact one without and with dissipation, the trapezoidal rule and the generalized-alpha method,
    the L-plate also with the exact one as five steps for one: drifts, the largest step that each
    holds (hardly any is halved, energy and momenta drift by 1 % at most), iterations, time, and how
    near the path is to that of a small step.  Finished runs are kept and not run again; runs that
    fail are results.  Exit status 1 if a promise of a scheme is not kept.

    \b
    Examples:
      corovec conserve l-plate
      corovec conserve --size full --jobs 2
    """
    from corovec.solver.results.files import writable_folder
    from corovec.solver.runtime.execution import processes

    from .campaign import Campaign
    from .conservation import ConservationStudy, conservation_tables, plans
    from .report import show_conservation
    from .study import run_studies
    from .tables import as_json as to_json
    from .tables import keeps_promises, origin, write_tables

    studies = [ConservationStudy(case, size) for case in dict.fromkeys(cases or plans(size))]
    folder = writable_folder(output)
    own = writable_folder(folder / size)
    with Campaign(folder / "runs", processes(jobs), notify=_tell) as campaign:
        outcomes = run_studies(studies, campaign)
    tables, whence = conservation_tables(studies, outcomes), origin(studies, outcomes)
    write_tables(own, tables, whence)
    if as_json:
        click.echo(json.dumps(to_json(tables, whence)))
    else:
        show_conservation(tables, own)
    if not keeps_promises(tables["verdicts"]):
        sys.exit(1)


@click.command("claims")
@click.argument("case")
@click.argument("files", metavar="[FILE]...", nargs=-1, type=click.Path(dir_okay=False))
@click.option("-o", "--output", type=click.Path(dir_okay=False),
              help="File of the verdicts (JSON).")
@click.option("--overwrite", is_flag=True, help="Replace the file if it exists.")
@click.option("--json", "as_json", is_flag=True, help="Print the verdicts as one JSON object.")
def claim(case, files, output, overwrite, as_json):
    """What the paper claims with the figures of CASE, checked on the result FILES of its runs.

    One FILE a mesh, each of a finished run with frames.  Exit status 1 if a row deviates without an
    explanation; what the paper says is a finding then.

    \b
    Examples:
      corovec run l-plate --elements 30 --dt 0.01 --end-time 20 --output l30.h5
      corovec claims l-plate l30.h5
    """
    from corovec.benchmarks import load_case
    from corovec.solver.results.files import replacing, writable_path

    from .claims import as_json as to_json
    from .claims import claims, open_runs
    from .verdicts import PAPERS
    path = writable_path(output, overwrite) if output is not None else None
    load_case(case)
    runs = open_runs(case, files)
    found = claims(case, runs)
    report = to_json(case, runs, found)
    if path is not None:
        with replacing(path) as partial:
            partial.write_text(json.dumps(report, indent=1), encoding="utf-8")
    if as_json:
        click.echo(json.dumps(report))
    for figure, rows in found.items() if not as_json else ():
        click.echo("\n".join([figure, *(f"  {row}" for row in rows)]))
    if any(row.verdict == "deviates (open)" and row.kind not in PAPERS
           for rows in found.values() for row in rows):
        sys.exit(1)


@click.command()
@click.argument("case")
@click.option("--elements", type=int, required=True,
              help="The mesh, by its number of elements, whose printed energy is the target.")
@click.option("--dt", type=float, help="Time step [s]. Default: 1/200 of the loading time.")
@click.option("-o", "--output", type=click.Path(dir_okay=False),
              help="Model file to write.  Default: CASE-calibrated.toml.")
@click.option("--overwrite", is_flag=True, help="Replace the model file if it exists.")
def calibrate(case, elements, dt, output, overwrite):
    """Fit the peak of CASE's load to the paper's energy after unloading on one mesh.

    A copy of the case's model file is written with the peak that was found, marked calibrated, for
    corovec run; that energy is no check of it any more.  Where all loads are given, the factor is
    only shown.

    \b
    Examples:
      corovec calibrate ruler --elements 480
      corovec run ruler-calibrated.toml
    """
    from corovec.benchmarks import load_case
    from corovec.solver.input.files import calibrated_text, find_model
    from corovec.solver.results.files import replacing, writable_path

    from .calibration import calibrate as find
    definition = load_case(case)
    free = definition.free_peak
    output = f"{case}-calibrated.toml" if output is None else output
    path = free and writable_path(output, overwrite)
    factor, found = find(case, elements, dt=dt, progress=lambda factor, energy: click.echo(
        f"  load factor {factor:<12.8g} energy {energy:.6g} J"))
    click.echo(f"load factor {factor:.8g}: {found.source}")
    if free is None:
        click.echo(f"Not written: the loads of {case} are given, none is free.")
        return
    old = definition.histories[free].peak
    peak = factor * old.value
    with replacing(path) as partial:
        partial.write_text(calibrated_text(find_model(case), peak, found), encoding="utf-8")
    click.echo(f"peak of {free}(t) {peak:.8g} {old.unit}, calibrated, written to {printable(path)}")


def _tell(text):
    """A line on standard error that leaves the progress bar whole."""
    from tqdm import tqdm
    tqdm.write(f"corovec: warning: {printable(text)}", file=sys.stderr)
