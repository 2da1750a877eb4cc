"""Commands ``corovec plot`` and ``corovec animate``."""

import sys

import click

VIEW = click.option("--view", nargs=2, type=float, metavar="ELEVATION AZIMUTH",
                    help="Where to look from [degrees].  Default: where most is seen.")
SCALE = click.option("--scale", type=float, default=1.0, show_default=True,
                     help="Factor of the displacements.")


@click.command()
@click.argument("files", metavar="FILE...", nargs=-1, required=True,
                type=click.Path(dir_okay=False))
@click.option("--output", type=click.Path(file_okay=False), default="figures", show_default=True,
              help="Folder of the figures and their data, made if needed.")
@click.option("--format", "formats", multiple=True, default=("svg",), show_default=True,
              help="svg, pdf or png; may be given several times.")
@click.option("--at", nargs=3, type=float, multiple=True, metavar="X Y Z",
              help="Initial place of a node whose displacement is drawn [m]; may be given several "
                   "times.  Default: the points of the case, or the node that moves farthest.")
@click.option("--interval", type=float,
              help="Time [s] (in statics, load factor) between frames of the motion.  Default: 8 "
                   "frames.")
@SCALE
@VIEW
@click.option("--overwrite", is_flag=True, help="Replace figures that exist.")
def plot(files, output, formats, at, interval, scale, view, overwrite):
    """Figures of result FILES, of runs or static paths, finished or not, each with its data as CSV.

    Mesh and loads, energies, momenta and the motion for each FILE; displacements and, of several
    FILES of one case, total energies for all together.

    \b
    Examples:
      corovec plot run.h5
      corovec plot l30.h5 l120.h5 --output figures --format svg --format png
      corovec plot shell.h5 --at 2 1 0.05 --interval 0.25 --overwrite
    """
    from tqdm import tqdm

    from convergence.store import writable_folder
    from solver.recorder import writable_path

    from .gallery import gallery, open_together
    from .style import save, targets
    recordings = open_together(files)
    figures = gallery(recordings, at, interval, scale, view)
    paths = {name: targets(output, name, formats) for name in figures}
    folder = writable_folder(output)
    for path in sum(paths.values(), []):
        writable_path(path, overwrite)
    with tqdm(figures.items(), unit="figure", disable=None, file=sys.stderr, leave=False) as bar:
        for name, draw in bar:
            bar.set_postfix_str(name)
            for path in save(*draw(), folder, name, formats, overwrite):
                tqdm.write(str(path), file=sys.stdout)


@click.command()
@click.argument("file", type=click.Path(dir_okay=False))
@click.option("-o", "--output", required=True, type=click.Path(dir_okay=False),
              help="The film, by its ending a .gif, an .mp4 (needs ffmpeg, or the extra [mp4]) or "
                   "an .html page.")
@click.option("--fps", type=float, default=25.0, show_default=True, help="Frames a second.")
@click.option("--frames", type=int,
              help="How many of the recorded frames to show.  Default: all.")
@click.option("--follow", is_flag=True, help="Keep the shell in the middle of the picture.")
@SCALE
@VIEW
@click.option("--overwrite", is_flag=True, help="Replace the film if it exists.")
def animate(file, output, fps, frames, follow, scale, view, overwrite):
    """A film of a result FILE: the shell in motion, coloured by strain energy, and its energies.

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

        click.echo(film(recording, output, fps=fps, frames=frames, scale=scale, view=view,
                        follow=follow, overwrite=overwrite, progress=progress))
