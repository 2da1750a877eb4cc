"""``python -m solver`` is ``corovec``."""

from .cli import main

main()
