"""Clusters: an own one, one that runs already, and one that does not."""

import re
import signal
from collections.abc import Iterator

import pytest

from rwjax.errors import InputError
from rwjax.fleet import cluster
from rwjax.fleet.cluster import connected

distributed = pytest.importorskip("distributed", reason="a fleet needs the extra `fleet`")


def test_a_scheduler_that_runs_already_is_used_and_goes_on() -> None:
    with distributed.LocalCluster(n_workers=1, processes=False, protocol="tcp", dashboard_address=":0") as own:
        with connected(own.scheduler_address, None, None) as client:
            assert client.submit(sum, [1, 2]).result() == 3
        assert own.status.name == "running"


def blocked() -> set[int]:
    """The signals that do not reach the calling thread."""
    return set(map(int, signal.pthread_sigmask(signal.SIG_BLOCK, set())))


def test_ctrl_c_reaches_no_worker_of_an_own_cluster_from_its_first_moment() -> None:
    with connected(None, 1, None) as client:
        assert signal.SIGINT in client.submit(blocked).result()
    assert signal.SIGINT not in blocked()


class Terminated(Exception):
    """What a program's own handler of SIGTERM raises."""


@pytest.fixture
def own_sigterm() -> Iterator[None]:
    def handler(number: int, frame: object) -> None:
        raise Terminated

    before = signal.signal(signal.SIGTERM, handler)
    yield
    signal.signal(signal.SIGTERM, before)


@pytest.mark.usefixtures("hears_ctrl_c", "own_sigterm")
@pytest.mark.parametrize(("number", "raised"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, Terminated)])
def test_ctrl_c_while_an_own_cluster_begins_is_heeded_when_it_has_begun_and_ends_it(
    number: signal.Signals,
    raised: type[BaseException],
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    begun = []

    class Interrupted(distributed.LocalCluster):
        def __init__(self, **given: object) -> None:
            signal.raise_signal(number)
            super().__init__(**given)
            begun.append(self)

    monkeypatch.setattr(distributed, "LocalCluster", Interrupted)
    with pytest.raises(raised), connected(None, 1, None):
        pass
    assert begun[0].status.name == "closed" and "Traceback" not in capfd.readouterr().err


def test_a_scheduler_that_does_not_answer_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "WAITS_S", 0.5)
    with (
        pytest.raises(InputError, match=re.escape("--scheduler tcp://127.0.0.1:9: does not answer")),
        connected("tcp://127.0.0.1:9", None, None),
    ):
        pass


def test_a_scheduler_without_a_worker_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "WAITS_S", 0.5)
    with distributed.LocalCluster(n_workers=0, processes=False, protocol="tcp", dashboard_address=":0") as own:
        refused = pytest.raises(InputError, match=r"has no worker; start one with `dask worker`")
        with refused, connected(own.scheduler_address, None, None):
            pass


def test_a_memory_that_is_no_size_is_said() -> None:
    with pytest.raises(InputError, match="--memory much: is no size; write one as 2GiB"), connected(None, 1, "much"):
        pass


@pytest.mark.parametrize("memory", ["2", "200", "1MiB", "255MiB", "-2GiB"])
def test_a_memory_with_which_no_process_begins_is_refused(memory: str) -> None:
    refused = pytest.raises(InputError, match=f"--memory {memory}: a process needs 256 MiB at least; write one as 2GiB")
    with refused, connected(None, 1, memory):
        pass
