"""Names that users give, in the languages that they reach: one line of text, matplotlib's texts.

Pages of HTML escape them where they are rendered.
"""


def printable(text):
    """``text`` in one line that terminals and files can show: what is not printable (line ends,
    escapes, bytes of no encoding) as the escape sequence that Python writes."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in str(text))


def mathtext(name):
    """``name`` as a text of matplotlib, to which a dollar begins a formula, and a label that begins
    with an underscore is none."""
    text = printable(name).replace("$", r"\$")
    return f" {text}" if text.startswith("_") else text


def listed(numbers, most=8):
    """The first of many ``numbers``, and how many there are: ``1, 2, 3 ... (40 in all)``."""
    rest = f" ... ({len(numbers)} in all)" if len(numbers) > most else ""
    return ", ".join(str(number) for number in numbers[:most]) + rest


LONGEST_NAME = 26
"""Letters of a name that leave room for a picture."""


def shortened(name):
    """A name with its middle left out if it is too long for a picture."""
    half = LONGEST_NAME // 2
    return name if len(name) <= LONGEST_NAME else f"{name[:half - 1]}…{name[-half:]}"
