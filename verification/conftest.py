"""Settings of all tests of this package."""

from hypothesis import settings

# compiling a kernel takes longer than any per-example deadline; examples are the same every run
settings.register_profile("corovec", deadline=None, derandomize=True, max_examples=200)
settings.load_profile("corovec")
