"""The command `rwjax` within the process of a test."""

import sys

import pytest

from rwjax.cli.main import main


def rwjax(patch: pytest.MonkeyPatch, *arguments: object) -> int:
    """Status with which the command ends."""
    patch.setattr(sys, "argv", ["rwjax", *map(str, arguments)])
    with pytest.raises(SystemExit) as ended:
        main()
    return int(ended.value.code or 0)
