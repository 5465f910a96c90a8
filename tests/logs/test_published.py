"""Published sets, fetched from a server of our own: nothing here needs a network, and nothing of the sets is committed."""

import gc
import hashlib
import socket
import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from scipy.io import loadmat, savemat

from rwjax import InputError, read_logs, read_rig
from rwjax.logs import published
from rwjax.logs.published import SETS, fetch

pytest.importorskip("pooch", reason="fetching a published set needs the extra `data`")
# pooch leaves the connection of a refused answer to the garbage collector, which says so
pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")


class Quiet(SimpleHTTPRequestHandler):
    """Serves a folder without a word."""

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture
def served(tmp_path: Path) -> Iterator[tuple[Path, str]]:
    """A folder, and its address on a server of this process."""
    folder = tmp_path / "served"
    folder.mkdir()
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder)))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield folder, f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()
    thread.join()
    server.server_close()
    gc.collect()


def like_emps(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files with the names and the columns of EMPS, whose check sums then count."""
    t = [[0.001 * k] for k in range(50)]
    for name in SETS["emps"].files:
        savemat(folder / name, {"t": t, "vir": t, "qm": t, "qg": t, "gtau": [[35.15]]})
    sums = {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in SETS["emps"].files}
    monkeypatch.setitem(published.SETS, "emps", SETS["emps"]._replace(files=sums))


def test_a_set_comes_with_a_rig_file_that_reads_it(
    served: tuple[Path, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, address = served
    like_emps(folder, monkeypatch)
    rig_file, *logs = fetch("emps", tmp_path / "emps", address)
    read = read_logs(logs, read_rig(rig_file))
    assert [len(log.time) for log in read] == [50, 50] and "yaw_rad" in read[0].outputs
    rig_file.write_text(rig_file.read_text().replace("80.0", "90.0"))
    (folder / "DATA_EMPS.mat").unlink()  # what is there is not fetched again, and a file that a user has changed stays
    fetch("emps", tmp_path / "emps", address)
    assert "90.0" in rig_file.read_text()


def test_another_file_than_the_published_one_is_refused_and_not_kept(served: tuple[Path, str], tmp_path: Path) -> None:
    folder, address = served
    for name in SETS["emps"].files:
        (folder / name).write_bytes(b"something else")
    with pytest.raises(InputError, match=r"DATA_EMPS\.mat: cannot be fetched: .*hash") as refused:
        fetch("emps", tmp_path / "emps", address)
    assert "\n" not in str(refused.value) and not (tmp_path / "emps").exists()


def test_what_a_user_has_there_is_not_replaced(
    served: tuple[Path, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, address = served
    like_emps(folder, monkeypatch)
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "DATA_EMPS.mat").write_bytes(b"mine")
    with pytest.raises(InputError, match=r"DATA_EMPS\.mat: is not the published file"):
        fetch("emps", mine, address)
    (mine / "DATA_EMPS.mat").unlink()
    (mine / "rig.toml").write_text(SETS["emps"].text.replace('"EMPS"', '"mine"'))
    with pytest.raises(InputError, match=r"rig\.toml: is of another rig"):
        fetch("emps", mine, address)
    assert [path.name for path in mine.iterdir()] == ["rig.toml"]


def test_no_such_address_is_said_in_one_line(served: tuple[Path, str], tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"DATA_EMPS\.mat: cannot be fetched: 404") as refused:
        fetch("emps", tmp_path / "emps", served[1])
    assert "\n" not in str(refused.value)


def test_a_host_that_is_not_reached_is_said_in_short_and_no_folder_stays(tmp_path: Path) -> None:
    with socket.socket() as taken:  # bound, and not listened at: nothing answers there
        taken.bind(("127.0.0.1", 0))
        host = f"127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(InputError, match=rf"^{host}: cannot be reached, where DATA_EMPS\.mat lies; try again"):
            fetch("emps", tmp_path / "some" / "emps", f"http://{host}/some/")
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_made_is_to_blame(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"file/x: cannot make this folder \(Not a directory\); give another one"):
        fetch("emps", tmp_path / "file" / "x")


def test_the_published_files_are_those_of_the_check_sums(realdata: Path) -> None:
    for name, digest in SETS["emps"].files.items():
        path = realdata / "emps" / "original_mat" / name
        assert hashlib.sha256(path.read_bytes()).hexdigest() == digest
        assert {"t", "vir", "qm"} <= {*loadmat(path)}
