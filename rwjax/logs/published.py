"""Logs of real rigs that others published, fetched from where they lie: each file with its check sum, and a first rig file beside it."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple
from urllib.parse import urlsplit

from rwjax.errors import InputError
from rwjax.rig.read import parse_rig, read_rig
from rwjax.text_files import write_text


class Published(NamedTuple):
    """A published set of logs.

    Attributes:
        rig: What was measured, in words.
        source: Who published it, and where.
        licence: Under which licence, in words.
        address: Where the files lie.
        files: SHA-256 of each, by its name.
        text: A first rig file.
    """

    rig: str
    source: str
    licence: str
    address: str
    files: dict[str, str]
    text: str


SETS = {
    "emps": Published(
        "DC motor, ball screw and carriage in a position loop, 25 s at 1 kHz",
        "A. Janot, M. Gautier, M. Brunot: Data Set and Reference Models of EMPS, nonlinearbenchmark.org, 2019",
        "not stated for the data; the repository that carries this copy is Apache-2.0",
        "https://raw.githubusercontent.com/forgi86/sysid-neural-continuous/956aa7ecd73061b0321c6f6098d74c9e4a7ce67a/examples/EMPS/data/",
        {
            "DATA_EMPS.mat": "6cf6814ae14618795da0101aae2bb97ff0c6351b0501b5492751b02b07facf7e",
            "DATA_EMPS_PULSES.mat": "0eab75bb1f6b16228ee78791343a88bf9bfd9a51036ac9807d7b5fc11c0e1704",
        },
        """\
kind = "platform"          # a linear axis: m for rad, kg for kg m2, N for N m
name = "EMPS"
[drive]
gain = 35.15065            # N/V, published with the logs
[axis]
inertia = 80.0             # kg; published: 95.1
[axis.friction]
viscous = 250.0            # N s/m; published: 203.5, and dry friction, which this file lacks
[columns]
time_s = "t"
voltage_V = "vir"
position_m = "qm"
[fit]
free = ["axis.inertia", "axis.friction.viscous"]
""",
    ),
}
"""Every set, by its name."""
RIG_FILE = "rig.toml"


def fetch(name: str, folder: Path, address: str | None = None) -> list[Path]:
    """Fetches a published set, and writes a first rig file beside its logs. What is there already is neither fetched nor replaced.

    Args:
        name: A key of `SETS`.
        folder: Where to put it; made where it is not there.
        address: Where the files lie, where not at the set's own address.

    Returns:
        The rig file, then the logs.

    Raises:
        InputError: pooch is not installed, the folder cannot be made, a file cannot be fetched or is not the published one, or the folder holds another rig file.
    """
    try:
        import pooch
        from requests import ConnectionError, Timeout
    except ImportError as why:
        raise InputError("fetching a published set needs pooch: pip install '.[data]'") from why
    one, rig_file = SETS[name], folder / RIG_FILE
    base = address or one.address
    if rig_file.exists() and read_rig(rig_file).name != parse_rig(one.text).name:
        raise InputError(f"{rig_file}: is of another rig; give another folder with -o")
    pooch.get_logger().setLevel("WARNING")
    with _made(folder):
        found = []
        for file, digest in one.files.items():
            if (there := folder / file).exists() and pooch.file_hash(str(there)) != digest:
                raise InputError(f"{there}: is not the published file; remove it, or give another folder with -o")
            try:
                found.append(Path(pooch.retrieve(base + file, f"sha256:{digest}", file, folder)))
            except (ConnectionError, Timeout) as why:
                host = urlsplit(base).netloc
                raise InputError(f"{host}: cannot be reached, where {file} lies; try again with a network") from why
            except (OSError, ValueError) as why:  # no such file there, no room; another file than the published one
                raise InputError(f"{base + file}: cannot be fetched: {' '.join(str(why).split())}") from why
    if not rig_file.exists():
        write_text(rig_file, one.text, InputError)
    return [rig_file, *found]


@contextmanager
def _made(folder: Path) -> Iterator[None]:
    """Makes a folder, which stays where something was put into it. Raises `InputError` where it cannot be made."""
    new = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as bad:
        raise InputError(f"{folder}: cannot make this folder ({bad.strerror}); give another one with -o") from None
    try:
        yield
    finally:
        with suppress(OSError):  # the first that holds something stays, and those above it
            for path in new:
                path.rmdir()
