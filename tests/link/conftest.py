"""What the tests of recordings share."""

import pytest

from rwjax.link import recorder
from tests.link.ports import Scripted


@pytest.fixture
def scripted(monkeypatch: pytest.MonkeyPatch):
    """Makes `record` open a scripted port."""

    def use(port: Scripted) -> Scripted:
        monkeypatch.setattr(recorder, "open_port", lambda _: port)
        return port

    return use
