"""Formulas become MathML while the site is built, so that no page needs a script or the network."""

import html
import re

from latex2mathml.converter import convert

FORMULA = re.compile(r'<(span|div) class="arithmatex">(.*?)</\1>', re.DOTALL)


def on_page_content(text, **_):
    """Replace what arithmatex marked, ``\\(...\\)`` in a span and ``\\[...\\]`` in a div."""
    return FORMULA.sub(_as_mathml, text)


def _as_mathml(match):
    formula = html.unescape(match[2]).strip()[2:-2].strip()
    display = "block" if match[1] == "div" else "inline"
    return convert(formula, display=display)
