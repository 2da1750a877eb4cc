"""Paths that may be written, files that replace others at once, space claimed beforehand."""

import os
import stat
import tempfile
from contextlib import contextmanager
from pathlib import Path

from ..checks import flag, shown
from ..errors import InputError, ResultFileError


def output_path(output, overwrite, resume):
    """The file that a run may write to, or None; see ``writable_path``."""
    resume, overwrite = flag("resume", resume), flag("overwrite", overwrite)
    if resume and overwrite:
        raise InputError("resume and overwrite exclude each other")
    if resume and output is None:
        raise InputError("resume needs output, the file to continue")
    return None if output is None else writable_path(output, overwrite or resume)


def writable_path(path, overwrite=False):
    """``path`` with links resolved.

    Raises:
        ResultFileError: it is no path, exists and is not to be overwritten, is not a file, or has
            no folder to be in.
    """
    path, exists = regular_file(path)
    if exists and not overwrite:
        raise ResultFileError(f"{path} exists; overwrite replaces it")
    if not path.parent.is_dir():
        raise ResultFileError(f"{path} cannot be created: no folder {path.parent}")
    return path


def writable_folder(path):
    """The folder ``path``, made if needed, with links resolved.

    Raises:
        ResultFileError: it is not a folder, or cannot be made or written to.
    """
    if not str(path):
        raise ResultFileError("the name of the folder is empty")
    path = Path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            return path.resolve()
    except FileExistsError:
        raise ResultFileError(f"{path} is not a folder") from None
    except OSError as error:
        raise ResultFileError(f"folder {path} cannot be written: {error.strerror}") from None


@contextmanager
def replacing(path):
    """A temporary file beside ``path`` that takes its place at the end, unless something fails."""
    partial = None
    try:
        handle, name = tempfile.mkstemp(".part", path.name[:100] + ".", path.parent)
        os.close(handle)
        partial = Path(name)
        yield partial
        partial.chmod(0o666 & ~_umask())
        os.replace(partial, path)
    finally:
        if partial is not None:
            partial.unlink(missing_ok=True)


def regular_file(given):
    """``given`` as a path with links resolved, and whether it exists."""
    try:
        if not os.fspath(given):
            raise ValueError("empty")
        path = Path(given).resolve()
        try:
            regular = stat.S_ISREG(path.stat().st_mode)
        except (FileNotFoundError, NotADirectoryError):
            return path, False
    except (TypeError, ValueError, OSError, RuntimeError) as error:
        raise ResultFileError(f"{shown(given)} is not a path of a file: "
                              f"{reason(error)}") from None
    if not regular:
        raise ResultFileError(f"{path} is not a regular file")
    return path, True


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


def _umask():
    current = os.umask(0)
    os.umask(current)
    return current
