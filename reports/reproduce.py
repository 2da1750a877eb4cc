"""From nothing to one page: every part runs once, whatever becomes of the others; then the page."""

import time
from concurrent.futures import ThreadPoolExecutor, as_completed

from corovec.solver.runtime.provenance import usable_cores

from .parts import LONGEST, Stamps
from .processes import execute


def run_parts(chosen, folder, jobs=None, tell=lambda text: None, running=lambda *_: None):
    """Run the parts that are not finished, each in a process of its own.

    Timings come first, one at a time with nothing beside them; then ``jobs`` parts at a time, by
    default one a usable core, ``LONGEST`` first, and last those that read the results of others.  A
    part that fails is stamped so, and the rest goes on.

    Args:
        chosen: ``Part`` s, each after its inputs.
        folder: of all results.
        jobs: parts at a time.
        tell: called with a line of text as parts end.
        running: called with the names of the parts that run, and how many have ended of how many.

    Returns:
        int: how many parts failed.
    """
    stamps = Stamps(_made(folder / "parts"))
    missing = _missing(chosen, stamps)
    if len(missing) < len(chosen):
        tell(f"{len(chosen) - len(missing)} of {len(chosen)} parts are there already")
    ended, failed, under_way = 0, 0, []

    def begin(part):
        under_way.append(part.name)
        running(under_way, ended, len(missing))
        return _run(part, stamps)

    for part, status, seconds in _run_all(missing, begin, jobs or usable_cores()):
        ended, failed = ended + 1, failed + (status != "finished")
        under_way.remove(part.name)
        running(under_way, ended, len(missing))
        tell(f"[{ended:>2}/{len(missing)}] {part.name:<24} {status:<9} {seconds:6.0f} s")
    return failed


def _missing(chosen, stamps):
    """Parts that are not finished, or will not be once their inputs have run again."""
    missing = []
    for part in chosen:
        if not stamps.finished(part) or any(each in missing for each in part.inputs):
            missing.append(part)
    return missing


def _run_all(missing, run, jobs):
    """``run(part)`` of all parts: ``(part, status, seconds)`` as they end."""
    for part in missing:
        if part.alone:
            yield run(part)
    beside = sorted((part for part in missing if not part.alone), key=_turn)
    yield from _run_beside([part for part in beside if not part.inputs], run, jobs)
    yield from _run_beside([part for part in beside if part.inputs], run, jobs)


def _turn(part):
    """Where a part stands among those that run beside others; all but ``LONGEST`` as they were."""
    return LONGEST.index(part.name) if part.name in LONGEST else len(LONGEST)


def _run_beside(chosen, run, jobs):
    """As ``_run_all``, ``jobs`` parts at a time."""
    with ThreadPoolExecutor(jobs) as pool:
        try:
            for future in as_completed([pool.submit(run, part) for part in chosen]):
                yield future.result()
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def _run(part, stamps):
    """One part in a process of its own, its stamp and its log."""
    command = (*part.command, *map(str, stamps.input_files(part)))
    if part.kind == "run":
        stamp = stamps.current(part)
        begun = stamp and stamp["status"] != "finished" and part.result.exists()
        command += ("--resume",) if begun else ("--overwrite",)
    stamps.write(part, "begun")
    _made(part.result.parent if part.kind != "time" else part.result.parent.parent)
    clock, began = time.perf_counter(), time.time()
    stamps.log(part).write_bytes(b"")
    code = execute(command, stamps.log(part))
    seconds = time.perf_counter() - clock
    written = part.result.exists() and part.result.stat().st_mtime >= began - 1.0
    good = code == 0 or code == 1 and part.judged and written and part.whole()
    status = "finished" if good else "failed"
    stamps.write(part, status, seconds, "" if good else _last_line(stamps.log(part), code))
    return part, status, seconds


def _last_line(log, code):
    """What a part that failed said last."""
    lines = log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
    return lines[-1] if lines else f"exit status {code}"


def _made(folder):
    folder.mkdir(parents=True, exist_ok=True)
    return folder
