"""A study as text on the terminal."""

import click
import numpy as np

from corovec.solver.names import printable
from corovec.verification.case import OK

from .study import printed_results
from .verdicts import assumptions


def show(study, tables, folder):
    """Print the tables of a study; ``folder`` is where they were written."""
    printed = printed_results(study.case)
    beside = f", beside {printed['table']} of the paper" if printed else ""
    click.echo(f"{study.definition.title}: energy after load removal{beside}")
    _show_mesh(tables["mesh"])
    _show_summary(tables["summary"])
    _show_dissipation(tables["dissipation"])
    if study.motion:
        _show_motion(study.motion["figure"], tables["motion"], tables["symmetry"], tables["growth"])
    _show_verdicts(tables["verdicts"])
    _show_runs(tables["runs"])
    if why := assumptions(study.definition):
        click.echo(f"Agreement is not proof: {why} (corovec list shows them).")
    click.echo(f"Tables and verdicts: {printable(folder)}\n")


def show_conservation(tables, folder):
    """Print the tables of a study of conservation; ``folder`` is where they were written."""
    click.echo(f"{'case':<11} {'scheme':<18} {'dt [s]':>8} {'until [s]':>10} {'E drift':>8} "
               f"{'L drift':>8} {'J drift':>8} {'E rise':>8} {'iterations':>10} {'halved':>7} "
               f"{'CPU s/s':>8} {'path':>8}")
    for row in tables["flights"].itertuples():
        click.echo(f"{row.case:<11} {row.scheme:<18} {row.dt:>8g} {row.reached:>10.4g} "
                   f"{row.energy_drift:>8.1e} {row.linear_momentum_drift:>8.1e} "
                   f"{row.angular_momentum_drift:>8.1e} {row.energy_rise:>8.1e} "
                   f"{row.iterations_per_step:>10.1f} {row.halved_share:>7.2%} "
                   f"{row.cpu_per_second:>8.3g} {row.path_error:>8.1e}")
    for row in tables["schemes"].itertuples():
        click.echo(f"{row.case}, {row.scheme}: largest step held {row.largest_step:g} s"
                   + (" (none larger tried)" if row.larger_untried else ""))
    _show_verdicts(tables["verdicts"])
    click.echo(f"Tables and verdicts: {printable(folder)}")


def _show_mesh(mesh):
    finest = mesh["elements"].iloc[-1]
    click.echo(f"{'elements':>9} {'printed [J]':>12} {'error':>7} {'ours [J]':>10} {'dt':>8} "
               f"{'error':>7} {'difference':>11} {'E drift':>9} {'L drift':>9} {'J drift':>9} "
               f"{'time':>9}")
    for row in mesh.itertuples():
        click.echo(f"{row.elements:>9} {row.printed:>12} {_percent(row.error_of_printed):>7} "
                   f"{row.energy_limit:>10.3f} {'±' + format(row.limit_uncertainty, '.0e'):>8} "
                   f"{_percent(row.error):>7} {row.difference:>+11.2%} {row.energy_drift:>9.1e} "
                   f"{row.linear_momentum_drift:>9.1e} {row.angular_momentum_drift:>9.1e} "
                   f"{row.seconds:>7.1f} s")
    click.echo(f"Errors: relative to the mesh of {finest} elements, all at dt = "
               f"{mesh['dt'].iloc[0]:g} s.  Energies: at dt = 0, with what the time steps leave "
               f"uncertain.  Drifts: in free flight until {mesh['end_time'].iloc[0]:g} s.")


def _show_summary(summary):
    click.echo(f"{'':<40} {'ours':>9} {'from printed energies:':>23} {'all meshes':>11} "
               f"{'stated':>7}")
    for row in summary.itertuples():
        name = row.quantity + (f" [{row.unit}]" if row.unit else "")
        beside = (f"{_number(row.of_printed):>23} {_number(row.of_all_printed):>11} "
                  f"{row.printed:>7}".rstrip())
        click.echo(f"{name:<40} {_number(row.ours):>9} {beside or ' ' + row.note}".rstrip())


def _show_dissipation(dissipation):
    last = dissipation.groupby("rho_inf").last().sort_index(ascending=False)
    if len(last):
        changes = ", ".join(f"{row.energy_change:+.1e} ({rho:g})" for rho, row in last.iterrows())
        click.echo(f"energy change until {last['time'].iloc[0]:g} s, dt = {last['dt'].iloc[0]:g} s "
                   f"(rho_inf): {changes}")


def _show_motion(figure, motion, symmetry, growth):
    for row in motion.itertuples():
        click.echo(f"{figure}, until {row.until:g} s, dt = {row.dt:g} s: u_{row.component}"
                   f"({row.point}) {row.min:.4g} to {row.max:.4g} m, period {row.period:.4g} s "
                   f"({row.share_of_period:.1%} of the variance), correlation with itself "
                   f"{row.autocorrelation:.4f} after {row.lag:.4g} s")
    ends = symmetry["until"].iloc[[0, -1]]
    for row in growth.itertuples():
        own = symmetry[(symmetry["dt"] == row.dt) & (symmetry["plane"] == row.plane)]
        values = own.set_index("until")["asymmetry"]
        click.echo(f"asymmetry about {row.plane} over the radius, dt = {row.dt:g} s: "
                   + ", ".join(f"{values[end]:.1e} ({end:g} s)" for end in ends)
                   + f"; between them like exp({row.rate:.3g} t/s), R squared "
                   f"{row.rate_r_squared:.3f}, or t^{row.power:.3g}, {row.power_r_squared:.3f}")


def _show_verdicts(verdicts):
    for row in verdicts[~verdicts["verdict"].isin(OK)].itertuples():
        click.echo(f"{row.verdict}: {row.name}: {row.value:.4g}, reference {row.reference:.4g}, "
                   f"tolerance {row.tolerance:.1g}")
    counts = verdicts["verdict"].value_counts()
    click.echo("verdicts: " + ", ".join(f"{count} {name}" for name, count in counts.items()))


def _show_runs(runs):
    ended = runs["status"].value_counts()
    click.echo("runs: " + ", ".join(f"{count} {name}" for name, count in ended.items())
               + f", {runs['seconds'].sum():.0f} s of computing")


def _percent(value):
    return f"{value:.3%}" if np.isfinite(value) else ""


def _number(value):
    digits = ".4g" if abs(value) >= 1e-4 else ".1e"
    return f"{value:{digits}}" if np.isfinite(value) else ""
