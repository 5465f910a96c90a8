"""The command `decode`: logs from the raw stream of a recording."""

from pathlib import Path
from typing import Annotated

import typer

from rwjax.cli.recording import RigFile, check_output
from rwjax.cli.terminal import note, say
from rwjax.errors import InputError

RawFile = Annotated[Path, typer.Argument(metavar="RAW", help="raw stream of a recording (.raw)", show_default=False)]
Output = Annotated[Path | None, typer.Option("-o", metavar="LOG.csv", help="beside the stream without it")]


def decode(rig_file: RigFile, raw: RawFile, output: Output = None) -> None:
    """Logs from a raw stream, such as a recording that was killed has left.

    Example: `rwjax decode rig.toml run.raw -o run.csv`
    """
    from rwjax.link.stream_to_logs import write_logs
    from rwjax.rig.read import read_one_axis_rig

    if raw.is_dir():
        raise InputError(f"{raw}: is a folder; give the path of a raw stream")
    if raw.suffix.lower() == ".csv":
        raise InputError(f"{raw}: is a log already; give the raw stream that a recording has left (.raw)")
    target = output or raw.with_suffix(".csv")
    check_output(target)
    logs, remarks = write_logs(raw, read_one_axis_rig(rig_file), target)
    if not logs:
        why = "; ".join(remarks) or "is this a raw stream of the testbed's board?"
        raise InputError(f"{raw}: holds no stretch of samples for a log; {why}")
    say("\n".join(map(str, logs)))
    note(*remarks)
