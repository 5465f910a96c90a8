"""Templates: values stand in them as they are, and none may be missing."""

import jinja2
import pytest

from rwjax.export.c_header import c_header
from rwjax.export.template import rendered
from tests.systems import platform


def test_a_value_that_is_missing_is_an_error() -> None:
    assert c_header(platform()).text.endswith("#endif\n")
    with pytest.raises(jinja2.UndefinedError):
        rendered("feed_forward.h.j2", rig=platform())
