"""What the site needs while it is built.

Formulas become MathML, so that no page needs a script or the network.  The sources are laid out as
they are installed, in ``build/api/corovec``, for mkdocstrings, which reads files and imports none.
"""

import html
import re
import shutil
from pathlib import Path

from latex2mathml.converter import convert

ROOT = Path(__file__).parents[1]
FORMULA = re.compile(r'<(span|div) class="arithmatex">(.*?)</\1>', re.DOTALL)
PYTHON_ONLY = shutil.ignore_patterns("__pycache__", "test_*.py", "conftest.py")


def on_startup(**_):
    """A copy of the package's folders, side by side, before mkdocstrings looks for it."""
    package = ROOT / "build" / "api" / "corovec"
    shutil.rmtree(package, ignore_errors=True)
    shutil.copytree(ROOT / "src" / "corovec", package, ignore=PYTHON_ONLY)
    for source in ROOT.glob("*/__init__.py"):
        shutil.copytree(source.parent, package / source.parent.name, ignore=PYTHON_ONLY)


def on_page_content(text, **_):
    """Replace what arithmatex marked, ``\\(...\\)`` in a span and ``\\[...\\]`` in a div."""
    return FORMULA.sub(_as_mathml, text)


def _as_mathml(match):
    formula = html.unescape(match[2]).strip()[2:-2].strip()
    return convert(formula, display="block" if match[1] == "div" else "inline")
