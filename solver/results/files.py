"""Paths that may be written, files that replace others at once, space claimed beforehand."""

import os
import stat
import tempfile
import uuid
from contextlib import contextmanager
from pathlib import Path
from subprocess import CalledProcessError

from ..checks import flag, shown
from ..errors import InputError, ResultFileError

PROBE = 1 << 14
"""Bytes that a folder must have room for before long work begins."""


RUN = ", resume continues its run"
"""What else can be done with a result file."""


def output_path(output, overwrite, resume):
    """The file that a run may write to, or None; see ``writable_path``."""
    resume, overwrite = flag("resume", resume), flag("overwrite", overwrite)
    if resume and overwrite:
        raise InputError("resume and overwrite exclude each other")
    if resume and output is None:
        raise InputError("resume needs output, the file to continue")
    return None if output is None else writable_path(output, overwrite or resume, RUN)


def writable_path(path, overwrite=False, otherwise=""):
    """``path``, absolute, with the links of its folder resolved.

    ``otherwise``: what can be done with one that exists, beside replacing it.

    Raises:
        ResultFileError: it is no path, exists and is not to be overwritten, is a symbolic link or
            not a file, or neither it nor its folder can be written.
    """
    given, (path, exists) = path, regular_file(path)
    if os.path.islink(given):
        raise ResultFileError(f"{given} is a symbolic link; give the name of the file itself")
    if exists and not overwrite:
        raise ResultFileError(f"{path} exists; overwrite replaces it{otherwise}")
    if not path.parent.is_dir():
        raise ResultFileError(f"{path} cannot be created: no folder {path.parent}")
    if exists and not os.access(path, os.R_OK | os.W_OK):
        raise ResultFileError(f"{path} cannot be written: no permission")
    with written(path):
        _probe(path.parent)
    return path


def writable_folder(path):
    """The folder ``path``, made if needed, with links resolved.

    Raises:
        ResultFileError: it is not a folder, or cannot be made or written to.
    """
    path = folder_path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
        _probe(path)
    except FileExistsError:
        raise ResultFileError(f"{path} is not a folder") from None
    except OSError as error:
        raise ResultFileError(f"folder {path} cannot be written: {reason(error)}") from None
    return path


def folder_path(given):
    """``given`` as the path of a folder with links resolved, which need not exist.

    Raises:
        ResultFileError: it is no path.
    """
    return _resolved(given, "folder")


@contextmanager
def replacing(path):
    """A temporary file beside ``path`` that takes its place at the end, unless something fails.

    A file that is replaced leaves its mode and its owner.

    Raises:
        ResultFileError: the system cannot write it, or keep its owner.
    """
    with written(path), draft(path) as partial:
        yield partial


@contextmanager
def written(path):
    """Failures of the system while ``path`` is written, as ``ResultFileError``."""
    try:
        yield
    except OSError as error:
        raise ResultFileError(f"{path} cannot be written: {reason(error)}") from None
    except CalledProcessError as error:
        raise ResultFileError(f"{path} cannot be written: {Path(error.cmd[0]).name} failed with "
                              f"status {error.returncode}") from None


@contextmanager
def draft(path):
    """As ``replacing``, with an OSError where the system fails."""
    partial = path.with_name(f"{path.stem[:40]}.{uuid.uuid4().hex}.part{path.suffix[:10]}")
    try:
        _create(partial, path)
        yield partial
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def _create(partial, path):
    """An empty file with the mode and the owner of that at ``path``, or those of any new one."""
    old = os.lstat(path) if os.path.lexists(path) else None
    mode = 0o666 if old is None else stat.S_IMODE(old.st_mode)
    handle = os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode)
    try:
        if old is not None and hasattr(os, "fchown"):
            new = os.fstat(handle)
            if (new.st_uid, new.st_gid) != (old.st_uid, old.st_gid):
                os.fchown(handle, old.st_uid, old.st_gid)
            os.fchmod(handle, mode)
    finally:
        os.close(handle)


def regular_file(given):
    """``given`` as a path with links resolved, and whether it exists."""
    path = _resolved(given, "file")
    try:
        regular = stat.S_ISREG(path.stat().st_mode)
    except (FileNotFoundError, NotADirectoryError):
        return path, False
    except OSError as error:
        raise ResultFileError(f"{shown(given)} is not a path of a file: "
                              f"{reason(error)}") from None
    if not regular:
        raise ResultFileError(f"{path} is not a regular file")
    return path, True


def _resolved(given, what):
    """``given`` as an absolute path without links."""
    try:
        if not os.fspath(given):
            raise ValueError("empty")
        return Path(given).resolve()
    except (TypeError, ValueError, OSError, RuntimeError) as error:
        raise ResultFileError(f"{shown(given)} is not a path of a {what}: "
                              f"{reason(error)}") from None


def _probe(folder):
    """OSError where ``folder`` takes no file, or has no room."""
    with tempfile.TemporaryFile(dir=folder) as file:
        file.write(bytes(PROBE))


def claim(path, size):
    """Make the system set ``size`` bytes of disk aside for ``path``; OSError where it cannot."""
    with open(path, "ab") as file:
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(file.fileno(), 0, size)
        else:
            block = bytes(1 << 20)
            while (rest := size - file.tell()) > 0:
                file.write(block[:rest])


def reason(error):
    """First line of an error, without HDF5's nested explanations."""
    number = getattr(error, "errno", None)
    if number:
        return os.strerror(number)
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
