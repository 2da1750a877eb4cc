"""Wrong variants of the solver, to show that the suites catch them.

A mutant is the source with one piece of text replaced while it is imported, in a process of its
own (``mutated.py``); a mutant of a kernel is compiled anew.
"""

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from corovec import solver

ROOT = Path(solver.__file__).parent


@dataclass(frozen=True)
class Mutant:
    """One wrong variant.

    Attributes:
        name: what is wrong.
        file: source file of the solver, from its folder.
        old: the text that is replaced.
        new: what stands there instead.
        killers: the cases that must catch it.
    """

    name: str
    file: str
    old: str
    new: str
    killers: tuple

    def source(self):
        """The mutant's text.

        Raises:
            ValueError: the text to replace is not there exactly once.
        """
        text = (ROOT / self.file).read_text(encoding="utf-8")
        if text.count(self.old) != 1:
            raise ValueError(f"mutant '{self.name}': its text occurs {text.count(self.old)} times "
                             f"in {self.file}")
        return text.replace(self.old, self.new)


def deviating_rows(mutant, case):
    """How many rows of ``case`` deviate without explanation when the mutant runs it; 1 where the
    solver itself ends the case with a ``StepError``.

    Raises:
        RuntimeError: the run broke off instead of giving verdicts.
    """
    with tempfile.TemporaryDirectory(prefix="corovec-mutant-") as folder:
        source, output = Path(folder) / "source.py", Path(folder) / "verdicts.json"
        source.write_text(mutant.source(), encoding="utf-8")
        environment = dict(os.environ)
        if mutant.file.startswith("kernels/"):
            environment["NUMBA_CACHE_DIR"] = folder
        said = Path(folder) / "stderr"
        command = [sys.executable, "-m", "corovec.verification.mutated", str(ROOT / mutant.file),
                   str(source), case, str(output)]
        with open(said, "wb") as stderr, subprocess.Popen(
                command, env=environment, cwd=folder, stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL, stderr=stderr) as child:
            child.wait()
        if not output.exists():
            raise RuntimeError(f"mutant '{mutant.name}' gave no verdicts: "
                               f"{said.read_text(errors='replace').strip()}")
        found = json.loads(output.read_text())["cases"][0]
    error = found["error"] or ""
    if error and not error.startswith("StepError"):
        raise RuntimeError(f"mutant '{mutant.name}' ended {case}: {error}")
    return bool(error) + sum(row["verdict"] == "deviates (open)" for row in found["rows"])
