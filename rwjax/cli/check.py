"""The command `check`: what is odd about logs, before any fit."""

from typing import TYPE_CHECKING, Any

from rwjax.cli.options import Json, LogFiles, Quiet, RigFile, of_file
from rwjax.cli.progress import progress
from rwjax.cli.terminal import document, next_command, say
from rwjax.errors import InputError
from rwjax.report.answer import json_text

if TYPE_CHECKING:
    from rwjax.logs.findings import Finding
    from rwjax.logs.log import Log

SETTLE = (
    "the logs do not look like runs of this rig: settle what is asked about under `units`, in the logs or in the file"
)
"""What is said on stderr where the findings ask about units."""
UNWRAP = "readings wrap: settle what stands first under `readings`, in the logs; what is asked under `units` may come from it"
"""What is said on stderr where readings wrap besides."""


def check(rig_file: RigFile, log_files: LogFiles, as_json: Json = False, quiet: Quiet = False) -> None:
    """Look at logs before any fit: units, signs, clock, command, readings, and which free numbers of RIG they cannot tell.

    Example: `rwjax check rig.toml logs/*.csv`
    """
    from rwjax.errors import RigError
    from rwjax.fitting.questions.check import check as findings_of
    from rwjax.fitting.questions.numbers import NothingTold
    from rwjax.logs.findings import WRAPS
    from rwjax.logs.read import read_logs
    from rwjax.rig.read import read_rig

    with progress(quiet) as show:
        show("looking at the logs")
        rig = read_rig(rig_file)
        logs = read_logs(log_files, rig, outputs_required=False)
        with of_file(rig_file, RigError):
            found = findings_of(rig, logs)
    wraps = [finding for finding in found if finding.about == "readings" and WRAPS in finding.says]
    found = [*wraps, *(finding for finding in found if finding not in wraps)]
    usable = not any(finding.about == "units" for finding in found)
    if as_json:
        document(json_text(_json(usable, logs, found), indent=1) + "\n")
    else:
        stop = ["`rwjax fit` would stop here and ask; `--force` goes on even so"]
        lines = [f"- {finding.about}: {finding}" for finding in found] or [
            "nothing odd was found; how far the model is from these logs is another question"
        ]
        silent = any(isinstance(finding.says, NothingTold) for finding in found)
        fitted = not silent and any(not log.validate for log in logs)
        ahead = [next_command("fit" if rig.free else "diagnose", rig_file, *log_files)] if fitted else []
        say("\n".join([*map(str, logs), "", *lines, *(ahead if usable else stop)]))
    if not usable:
        asked = next(finding for finding in found if finding.about == "units")
        first = wraps[0] if wraps else asked
        raise InputError(f"{rig_file}: {first if as_json else UNWRAP if wraps else SETTLE}")


def _json(usable: bool, logs: "tuple[Log, ...]", found: "list[Finding]") -> dict[str, Any]:
    """The findings as plain objects."""
    return {
        "schema": "rwjax.check/1",
        "usable": usable,
        "logs": [
            {
                "name": log.name,
                "samples": len(log.time),
                "seconds": float(log.time[-1] - log.time[0]),
                "input": log.input,
                "outputs": [*log.outputs],
            }
            for log in logs
        ],
        "findings": [finding._asdict() for finding in found],
    }
