"""Work of a long run on processes of this machine, or on a Dask cluster: the same results, and what dies is left out."""

import os

import pytest

from experiments.workers import Workers, done, pool


def doubled(number: int) -> int:
    return 2 * number


def dies_of_three(number: int) -> int:
    if number == 3:
        os._exit(1)
    return number


def test_a_cluster_does_what_processes_do() -> None:
    distributed = pytest.importorskip("distributed", reason="a cluster needs the extra `fleet`")
    jobs = [(k,) for k in range(6)]
    with distributed.LocalCluster(n_workers=1, processes=False, protocol="tcp", dashboard_address=":0") as own:
        theirs = Workers(scheduler=own.scheduler_address)
        assert sorted(done(doubled, jobs, theirs)) == [0, 2, 4, 6, 8, 10]
        with pool(theirs) as executor:
            assert [*executor.map(doubled, range(6))] == [0, 2, 4, 6, 8, 10]
        with pytest.raises(TypeError):  # an error of the work is no lost worker
            list(done(doubled, [(1, 2)], theirs))


def test_what_a_dead_worker_had_is_left_out_and_said(capsys: pytest.CaptureFixture[str]) -> None:
    assert 3 not in done(dies_of_three, [(k,) for k in range(4)], Workers(1))
    assert "lost with a worker that died" in capsys.readouterr().out
