"""Damaged rig files, logs, plans and frames, and what rwjax does with them; `python -m tests.damage --help`."""
