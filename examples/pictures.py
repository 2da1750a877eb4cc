"""Run all examples and keep their pictures and what they print for docs/examples.md.

Usage: python examples/pictures.py
"""

import os
import subprocess
import sys
from pathlib import Path

EXAMPLES = ("panel", "satellite", "box", "free_plate", "roll_up", "snap_through", "t_junction",
            "fifty", "shaken", "postbuckling", "campbell", "wing",
            "solar_array", "chain", "flapping", "four_bar", "double_pendulum")
HERE = Path(__file__).parent
PICTURES = HERE.parent / "docs" / "pictures"


def run(name, picture):
    """Run one example in the folder of its picture; what it prints."""
    done = subprocess.run([sys.executable, str(HERE / f"{name}.py"), str(picture)], check=True,
                          cwd=picture.parent, env={**os.environ, "MPLBACKEND": "agg"},
                          capture_output=True, text=True)
    return done.stdout


if __name__ == "__main__":
    for name in EXAMPLES:
        print(f"{name}\n{run(name, PICTURES / f'{name}.png')}")
