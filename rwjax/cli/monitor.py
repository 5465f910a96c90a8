"""The command `monitor`: what the board sends, on the terminal."""

import sys
from contextlib import closing

from rwjax.cli.recording import Port, RigFile, live_view, needs_pyserial
from rwjax.errors import InputError


def monitor(rig_file: RigFile, port: Port) -> None:
    """Show what the board sends, until Ctrl-C.

    Example: `rwjax monitor rig.toml /dev/ttyACM0`
    """
    needs_pyserial()
    if not sys.stderr.isatty():
        raise InputError("monitor draws on a terminal, and stderr is none; `rwjax record` writes what the board sends")
    from rwjax.link.port import open_port
    from rwjax.link.recorder import listen
    from rwjax.link.session import Session
    from rwjax.rig.read import read_one_axis_rig

    rig = read_one_axis_rig(rig_file)
    with live_view(rig, quiet=False) as watch, closing(open_port(port)) as line:
        session = Session(line, watch=watch)
        session.greet()
        try:
            listen(None)(session)
        except KeyboardInterrupt:
            pass
