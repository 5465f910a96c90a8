"""Workers of an own cluster, and Ctrl-C."""

import signal

import pytest

from rwjax.fleet.undisturbed import dask_setup


@pytest.mark.usefixtures("hears_ctrl_c")
def test_a_worker_ignores_ctrl_c() -> None:
    dask_setup(None)
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
