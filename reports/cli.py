"""Commands ``corovec check``, ``plot``, ``animate``, ``reproduce``, ``record`` and ``numbers``."""

import sys
from pathlib import Path

import click

from corovec.solver.names import printable

VIEW = click.option("--view", nargs=2, type=float, metavar="ELEVATION AZIMUTH",
                    help="Where to look from [degrees].  Default: where most is seen.")
SCALE = click.option("--scale", type=float, default=1.0, show_default=True,
                     help="Factor of the displacements.")
COLOR = click.option("--color", default="strain_energy_density", show_default=True,
                     help="What colours the elements: of a file with stresses also von_mises (the "
                          "largest over the thickness), n_xx, n_yy, n_xy, m_xx, m_yy, m_xy, q_xz "
                          "or q_yz, in the axes of the elements.")


@click.command()
@click.argument("files", metavar="FILE...", nargs=-1, required=True,
                type=click.Path(dir_okay=False))
@click.option("-o", "--output", type=click.Path(file_okay=False), default="figures",
              show_default=True, help="Folder of the figures and their data, made if needed.")
@click.option("--format", "formats", multiple=True, default=("svg",), show_default=True,
              help="svg, pdf or png; may be given several times.")
@click.option("--at", nargs=3, type=float, multiple=True, metavar="X Y Z",
              help="Initial place of a node whose displacement is drawn [m]; may be given several "
                   "times.  Default: the points of the case, or the node that moves farthest.")
@click.option("--interval", type=float,
              help="Time [s] (in statics, load factor) between frames of the motion.  Default: 8 "
                   "frames.")
@COLOR
@SCALE
@VIEW
@click.option("--overwrite", is_flag=True, help="Replace figures that exist.")
def plot(files, output, formats, at, interval, color, scale, view, overwrite):
    """Figures of result FILES, of runs or static paths, finished or not, each with its data as CSV.

    Mesh and loads, energies, momenta, reactions and probes, the motion and, where stresses are
    recorded, von Mises stress and --color at the end for each FILE; displacements and, of several
    FILES of one case, total energies for all together.

    \b
    Examples:
      corovec plot run.h5
      corovec plot l30.h5 l120.h5 --output figures --format svg --format png
      corovec plot shell.h5 --at 2 1 0.05 --interval 0.25 --overwrite
      corovec plot stressed.h5 --color m_xx
    """
    from tqdm import tqdm

    from corovec.solver.results.files import writable_folder, writable_path

    from .gallery import gallery, open_together
    from .style import save, targets
    recordings = open_together(files)
    figures = gallery(recordings, at, interval, scale, view, color)
    paths = {name: targets(output, name, formats) for name in figures}
    folder = writable_folder(output)
    for path in sum(paths.values(), []):
        writable_path(path, overwrite)
    with tqdm(figures.items(), unit="figure", disable=None, file=sys.stderr, leave=False) as bar:
        for name, draw in bar:
            bar.set_postfix_str(name)
            for path in save(*draw(), folder, name, formats, overwrite):
                tqdm.write(printable(path), file=sys.stdout)


@click.command()
@click.argument("model")
@click.option("--elements", type=int, help="Mesh, by its number of elements.")
@click.option("-o", "--output", type=click.Path(dir_okay=False),
              help="The picture, a .svg, .png or .pdf.  Default: NAME-check.png.")
@VIEW
@click.option("--overwrite", is_flag=True, help="Replace the picture if it exists.")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as one JSON object.")
def check(model, elements, output, view, overwrite, as_json):
    """Check a MODEL file without running it, and draw all that it says: mesh, normals, groups,
    folds, supports, loads of every kind, initial motion.

    Prints mass, centre, inertia, extent, groups, sets, folds, the thickest and the most warped
    element, and what acts.  All errors of the file are told at once.

    \b
    Examples:
      corovec check my_shell.toml
      corovec check my_shell.toml --view 20 -60 --output shell.svg --overwrite
    """
    from .checking import check_model
    check_model(model, elements, output, view, overwrite, as_json)


@click.command()
@click.argument("file", type=click.Path(dir_okay=False))
@click.option("-o", "--output", required=True, type=click.Path(dir_okay=False),
              help="The film, by its ending a .gif, an .mp4 (needs ffmpeg, or the extra [mp4]) or "
                   "an .html page.")
@click.option("--fps", type=float, default=25.0, show_default=True, help="Frames a second.")
@click.option("--frames", type=int,
              help="How many of the recorded frames to show.  Default: all.")
@click.option("--follow", is_flag=True, help="Keep the shell in the middle of the picture.")
@COLOR
@SCALE
@VIEW
@click.option("--overwrite", is_flag=True, help="Replace the film if it exists.")
def animate(file, output, fps, frames, follow, color, scale, view, overwrite):
    """A film of a result FILE: the shell in motion, coloured by strain energy or a stress, and its
    energies.

    \b
    Examples:
      corovec animate run.h5 -o motion.gif
      corovec animate run.h5 -o motion.mp4 --fps 30 --follow
      corovec animate run.h5 -o motion.html --frames 50 --view 30 -60
    """
    from tqdm import tqdm

    from .film import animate as film
    from .recording import Recording
    recording = Recording.open(file)
    with tqdm(unit="frame", disable=None, file=sys.stderr, leave=False) as bar:

        def progress(k, n):
            bar.total = n
            bar.update(k - bar.n)

        path = film(recording, output, fps=fps, frames=frames, scale=scale, view=view,
                    follow=follow, color=color, overwrite=overwrite, progress=progress)
        click.echo(printable(path))


def _shapes(command):
    """Options that ``modes`` and ``buckling`` share."""
    for option in reversed((
            click.argument("model"),
            click.option("--elements", type=int, help="Mesh, by its number of elements."),
            click.option("-o", "--output", type=click.Path(dir_okay=False),
                         help="The shapes for ParaView, a .vtu file."),
            click.option("--plot", "picture", type=click.Path(dir_okay=False),
                         help="Their picture, a .svg, .png or .pdf, with its data as CSV."),
            click.option("--film", type=click.Path(dir_okay=False),
                         help="A period of one of them, a .gif, .mp4 or .html."),
            click.option("--shape", type=int, default=1, show_default=True,
                         help="Number of the shape of the film."),
            SCALE, VIEW,
            click.option("--overwrite", is_flag=True, help="Replace files that exist."),
            click.option("--json", "as_json", is_flag=True,
                         help="Print the summary as one JSON object."))):
        command = option(command)
    return command


@click.command()
@_shapes
@click.option("--number", type=int, default=10, show_default=True, help="How many modes.")
@click.option("--unloaded", is_flag=True,
              help="About the initial shell, though the file has a static step.")
def modes(model, elements, number, unloaded, output, picture, film, overwrite, **how):
    """Eigenfrequencies and modes of a MODEL: a .toml file, or the name of a benchmark.

    About the equilibrium of its static step, where it has one, with the stress, the loads that
    follow the shell and the frame that turns there; else about the initial shell.

    \b
    Examples:
      corovec modes l-plate --elements 480
      corovec modes blade.toml --number 4 --plot modes.svg --output modes.vtu
      corovec modes blade.toml --film third.gif --shape 3
    """
    from corovec.solver.input.modal import modes_of

    from .modal import check_paths, tell
    check_paths(output, picture, film, overwrite)
    tell(*modes_of(model, elements, number, unloaded), output, picture, film, overwrite, **how)


@click.command()
@_shapes
@click.option("--number", type=int, default=3, show_default=True, help="How many load factors.")
def buckling(model, elements, number, output, picture, film, overwrite, **how):
    """Linear buckling of a MODEL under the loads of its static step, or all without one.

    Load factors above zero at which the initial shell, with the stress of its linear solution,
    loses its stability, and the shapes.

    \b
    Examples:
      corovec buckling panel.toml
      corovec buckling panel.toml --number 6 --plot shapes.svg --output shapes.vtu
    """
    from corovec.solver.input.modal import buckling_of

    from .modal import check_paths, tell
    check_paths(output, picture, film, overwrite)
    tell(*buckling_of(model, elements, number), output, picture, film, overwrite, **how)


@click.command()
@click.argument("names", metavar="[PART]...", nargs=-1)
@click.option("--size", default="quick", show_default=True,
              help="quick (minutes) or full (all meshes, the paper's simulated times: hours).")
@click.option("--jobs", type=int, help="Parts at a time.  Default: one a usable core.")
@click.option("-o", "--output", type=click.Path(file_okay=False), default="results/reproduce",
              show_default=True, help="Folder of all results; the page is SIZE/page/index.html.")
@click.option("--list", "list_only", is_flag=True, help="Show the parts and how they ended.")
@click.option("--page-only", is_flag=True, help="Run nothing; make the page of what is there.")
def reproduce(names, size, jobs, output, list_only, page_only):
    """Rerun every claim of the paper, and make one page of tables, figures and verdicts.

    Every PART (default: all of the size) is a corovec command of its own: timings, runs behind the
    figures, convergence studies, verification suites.  Finished parts are kept and not run again,
    interrupted runs go on, a part that fails is a row of the page.  Exit status 1 if one failed.

    \b
    Examples:
      corovec reproduce
      corovec reproduce --size full
      corovec reproduce time-table-2 verify
    """
    from corovec import InputError
    from corovec.solver.results.files import folder_path, writable_folder
    from corovec.solver.runtime.provenance import usable_cores

    from .page import build
    from .parts import Stamps, parts, select, status
    from .reproduce import run_parts
    if jobs is not None and jobs < 1:
        raise InputError(f"jobs must be at least 1, is {jobs}")
    if list_only and page_only:
        raise InputError("--list runs nothing and makes no page: leave out --page-only")
    folder = folder_path(output) / size
    chosen = select(parts(size, folder), names)
    if list_only:
        stamps = Stamps(folder / "parts")
        for part in parts(size, folder):
            click.echo(f"{part.name:<24} {status(part, stamps):<26} {part.shown()}")
        return
    failed = 0
    for each in (folder, folder / "parts", folder / "page"):
        writable_folder(each)
    if not page_only:
        from tqdm import tqdm
        with tqdm(unit="part", disable=None, file=sys.stderr, leave=False, mininterval=0.0) as bar:

            def running(names, ended, n):
                bar.total, bar.n = n, ended
                bar.set_postfix_str(", ".join(names))

            def tell(text):
                with tqdm.external_write_mode():
                    click.echo(text)

            failed = run_parts(chosen, folder, jobs, tell, running)
    page = build(size, folder, jobs or usable_cores())
    click.echo(f"{printable(page)} ({page.stat().st_size / 1e6:.1f} MB)")
    if failed:
        logs = printable(folder / "parts")
        click.echo(f"{failed} of {len(chosen)} parts failed; their logs are in {logs}")
        sys.exit(1)


@click.command()
@click.argument("folder", type=click.Path(file_okay=False))
@click.option("--list", "list_all", is_flag=True, help="Show all that moved, a line each.")
def record(folder, list_all):
    """Keep a small record of the studies and timings below FOLDER; tell what moved.

    FOLDER/records has a JSON file a commit: energies, drifts and verdicts of each study.json, times
    of each timing.json in units of a dense LU of the same run.  One line says what moved beyond
    rounding since the last record of another commit.  Exit status 1 if a verdict fell, from
    agreement to a deviation or from an explained one to an open one; timings never fail.

    \b
    Examples:
      corovec record timings
      corovec record results/reproduce/full --list
    """
    from corovec import InputError
    from corovec.solver.results.files import folder_path

    from .changes import compare
    from .records import below, keep, load, records_of
    folder = folder_path(folder)
    records = records_of(below(folder))
    if not records:
        raise InputError(f"{folder} holds no study.json or timing.json")
    compared = compare(records, *load(folder))
    keep(folder, records)
    click.echo(printable(compared.line()))
    for change in compared.changes if list_all else ():
        click.echo(printable(f"{change.kind}: {change}"))
    if compared.fell:
        sys.exit(1)


@click.command()
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path), required=False)
def numbers(folder):
    """Write the measured numbers of a reproduction FOLDER into README and documentation.

    FOLDER is that of one size, as results/reproduce/full, with the peers.json of corovec peers if
    there is one; of what is not in it the old numbers stay.  Without it the Markdown is only
    written anew from docs/numbers.json.

    \b
    Example:
      corovec numbers results/reproduce/full
    """
    from .numbers import update
    for page in update(folder):
        click.echo(f"{page} written anew")
