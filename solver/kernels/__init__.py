"""Compiled kernels: functions of plain arrays, nothing else (numpy and numba only).

Numba's on-disk cache does not notice an edit in a function that another file calls, so the cache
lives in a folder named after a hash of these sources: an edit of any kernel starts a new one.
"""

import hashlib
import os
import tempfile
from pathlib import Path

import numba


def cache_folder() -> str:
    """The folder of compiled kernels that belongs to exactly these sources."""
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.read_bytes())
    try:
        base = Path(os.environ.get("XDG_CACHE_HOME", ""))
        if not base.is_absolute():
            base = Path.home() / ".cache"
        folder = base / "corovec" / digest.hexdigest()[:16]
        folder.mkdir(parents=True, exist_ok=True)
        if os.access(folder, os.W_OK):
            return str(folder)
    except (OSError, RuntimeError):  # RuntimeError: there is no home
        pass
    user = os.getuid() if hasattr(os, "getuid") else 0
    fallback = Path(tempfile.gettempdir()) / f"corovec-{user}"
    try:
        fallback.mkdir(mode=0o700, exist_ok=True)
        if fallback.stat().st_uid == user:
            return str(fallback / digest.hexdigest()[:16])
    except OSError:
        pass
    return tempfile.mkdtemp(prefix="corovec-")


if not numba.config.CACHE_DIR:
    numba.config.CACHE_DIR = cache_folder()
