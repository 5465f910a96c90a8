"""The command line: arguments in, library called, results printed."""

from rwjax.cli import interrupt as interrupt  # Ctrl-C comes before what takes long to import
