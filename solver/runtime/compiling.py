"""Says that kernels are being compiled, once a process: it takes up to a minute."""

import sys

from numba.core import event

PACKAGE = __name__.partition(".")[0]


class _Announcement(event.Listener):
    """Speaks when the first kernel is compiled."""

    def __init__(self):
        self._made = False

    def on_start(self, event):
        kernel = event.data["dispatcher"].py_func
        if kernel.__module__.startswith(f"{PACKAGE}."):
            self.make()

    def on_end(self, event):
        pass

    def make(self):
        if not self._made:
            self._made = True
            print("corovec: compiling the kernels, about a minute, once", file=sys.stderr)


_announcement = _Announcement()
event.register("numba:compile", _announcement)
announce = _announcement.make
