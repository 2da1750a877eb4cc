"""Commands ``corovec converge`` and ``corovec calibrate``."""

import json
import sys

import click

from .study import mesh_study, planned_runs, printed_energies


@click.command()
@click.argument("case", default="l-plate")
@click.option("--elements", type=int, multiple=True,
              help="A mesh, by its number of elements; may be repeated. Default: the coarsest 3.")
@click.option("--dt", type=float, help="Time step [s]. Default: 1/500 of the loading time.")
@click.option("--membrane", default="stress", show_default=True,
              help="Assumed membrane field: stress, strain, or compatible (none).")
@click.option("--json", "as_json", is_flag=True, help="Print the table as one JSON object.")
def converge(case, elements, dt, membrane, as_json):
    """Energy of CASE after unloading, mesh by mesh, beside the paper's table.

    \b
    Examples:
      corovec converge l-plate
      corovec converge l-plate --elements 30 --elements 120 --elements 480 --elements 1920
      corovec converge l-plate --membrane strain --json
    """
    from solver import warm_up
    from solver.cases import load_case, read_calibrations
    definition = load_case(case)
    runs = planned_runs(case, elements, dt=dt, membrane=membrane)
    _, table = printed_energies(case)
    if not as_json:
        click.echo(f"{definition.title}: energy after load removal, beside {table} of the paper")
    compile_seconds = warm_up()
    if not as_json:
        click.echo(f"kernels compiled or loaded in {compile_seconds:.1f} s")
    frame = mesh_study(case, runs, progress=_bars)
    if as_json:
        click.echo(json.dumps({"case": case, "table": table, "compilation_seconds": compile_seconds,
                               "rows": frame.to_dict(orient="records")}))
        return
    click.echo(f"{'elements':>9} {'printed [J]':>12} {'ours [J]':>10} {'difference':>11} "
               f"{'energy drift':>13} {'L drift':>9} {'J drift':>9} {'it/step':>8} {'time':>8}")
    for row in frame.itertuples():
        click.echo(f"{row.elements:>9} {row.printed:>12} {row.energy:>10.3f} "
                   f"{row.difference_percent:>+10.2f}% {row.energy_drift:>13.1e} "
                   f"{row.linear_momentum_drift:>9.0e} {row.angular_momentum_drift:>9.0e} "
                   f"{row.iterations_per_step:>8.2f} {row.seconds:>6.1f} s")
    assumed = [parameter for parameter, _, _, provenance, _ in definition.provenance()
               if provenance == "assumed"]
    if assumed:
        click.echo(f"Agreement is not proof: the paper's figure is lost, so {len(assumed)} "
                   "parameters of this case are assumed (corovec list shows them).")
    fitted = read_calibrations().get(case)
    if fitted:
        click.echo(f"The load's peak is calibrated to the printed energy of {fitted.elements} "
                   "elements: that row is no check.")


@click.command()
@click.argument("case")
@click.option("--elements", type=int, required=True,
              help="The mesh, by its number of elements, whose printed energy is the target.")
@click.option("--dt", type=float, help="Time step [s]. Default: 1/200 of the loading time.")
def calibrate(case, elements, dt):
    """Fit the peak of CASE's load to the paper's energy after unloading on one mesh.

    The peak is written beside the case's definition, marked calibrated, and replaces the assumed
    one; that energy is no check any more.  Where all loads are given, the factor is only shown.

    \b
    Example:
      corovec calibrate ruler --elements 480
    """
    from solver import warm_up
    from solver.cases import CALIBRATED, load_case, write_calibration

    from .calibration import calibrate as find
    definition = load_case(case)
    warm_up()
    factor, found = find(case, elements, dt=dt, progress=lambda factor, energy: click.echo(
        f"  load factor {factor:<12.8g} energy {energy:.6g} J"))
    click.echo(f"load factor {factor:.8g}: {found.source}")
    if definition.free_peak is None:
        click.echo(f"Not written: the loads of {case} are given, none is free.")
        return
    write_calibration(case, found)
    unit = definition.histories[definition.free_peak].peak.unit
    click.echo(f"peak of {definition.free_peak}(t) {found.peak:.8g} {unit}, calibrated, written to "
               f"{CALIBRATED}")


def _bars(elements):
    """Progress callback of one run: a bar on standard error, silent when not a terminal."""
    from tqdm import tqdm
    bar = tqdm(desc=f"{elements} elements", unit="step", disable=None, file=sys.stderr, leave=False)

    def update(step, n_steps, row):
        bar.total = n_steps
        bar.update(1)
        if step == n_steps:
            bar.close()

    return update
