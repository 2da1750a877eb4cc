"""Names that users give, in all the places where they are shown."""

import pickle

import pytest
from matplotlib.figure import Figure

from corovec import InputError, ResultFileError, Settings, read, simulate
from corovec.solver.names import listed, mathtext, printable
from corovec.verification.models import rectangle

NAMES = ("a\nb", "\x1b[31mred", "$x{", "$a$ $", "b\udcff", "_under", "<b>&", "a\\$b", "\u202egnp")


@pytest.mark.parametrize("name", NAMES, ids=range(len(NAMES)))
def test_names_are_shown_as_they_are(name):
    """In one line, with what cannot be shown escaped; no dollar begins a formula."""
    shown = printable(name)
    assert shown.isprintable() and shown.encode()
    assert printable("Länge 1²") == "Länge 1²"
    figure = Figure()
    axes = figure.add_subplot()
    axes.plot([0, 1], label=mathtext(name))
    figure.draw_without_rendering()
    handles, labels = axes.get_legend_handles_labels()
    assert labels and axes.text(0, 0, labels[0])._preprocess_math(labels[0])[0].strip() == shown


@pytest.mark.parametrize("name", ["a\nb.h5", "\x1b[31m.h5", "b\udcff.h5"])
def test_errors_are_one_line_whatever_a_file_is_called(tmp_path, name):
    with pytest.raises(ResultFileError) as told:
        read(tmp_path / name)
    assert str(told.value).isprintable() and "does not exist" in str(told.value)
    again = pickle.loads(pickle.dumps(told.value))
    assert str(again) == str(told.value)


@pytest.mark.parametrize("case", ["a\nb", "", "\x1b[31m", "x" * 201])
def test_a_case_has_a_name_that_can_be_shown(case):
    with pytest.raises(InputError, match="case must be one line of 1 to 200 printable characters"):
        simulate(rectangle(1.0, 1.0, (1, 1)), Settings(dt=0.1, end_time=0.2), case=case)


def test_long_lists_are_short():
    assert listed([1, 2]) == "1, 2"
    assert listed(range(40)) == "0, 1, 2, 3, 4, 5, 6, 7 ... (40 in all)"
