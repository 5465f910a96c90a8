"""The command `check`: what is odd about logs, before any fit."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rwjax.cli.options import Json, LogFiles, Quiet, RigFile, of_file
from rwjax.cli.progress import progress
from rwjax.cli.terminal import document, listed, next_command, say
from rwjax.errors import InputError
from rwjax.kinds import GOAL
from rwjax.report.answer import json_text

if TYPE_CHECKING:
    from rwjax.logs.findings import Finding
    from rwjax.logs.log import Log
    from rwjax.rig.model import Rig

SETTLE = (
    "the logs do not look like runs of this rig: settle what is asked about under `units`, in the logs or in the file"
)
"""What is said on stderr where the findings ask about units."""
MENDED = ("wrap", "frozen", "dropout")
"""Kinds of findings that have to be mended in the logs before a fit."""
MEND = "mend first what stands under `readings`"
"""What is said where there are such."""
OR_AS_THEY_ARE = "; where the rig did rest there, `rwjax {}` takes the logs as they are"
"""What is said besides where none of them wraps: a rest may be one."""
UNWRAP = "readings wrap: settle what stands first under `readings`, in the logs; what is asked under `units` may come from it"
"""What is said on stderr where readings wrap besides."""


def check(rig_file: RigFile, log_files: LogFiles, as_json: Json = False, quiet: Quiet = False) -> None:
    """Look at logs before any fit: units, signs, clock, command, readings, and which free numbers of RIG they cannot tell.

    Example: `rwjax check rig.toml logs/*.csv`
    """
    from rwjax.errors import RigError
    from rwjax.fitting.questions.check import check as findings_of
    from rwjax.logs.read import read_logs
    from rwjax.rig.read import read_rig

    with progress(quiet) as show:
        show("looking at the logs")
        rig = read_rig(rig_file)
        logs = read_logs(log_files, rig, outputs_required=False)
        with of_file(rig_file, RigError):
            found = findings_of(rig, logs)
    wraps = [finding for finding in found if finding.kind == "wrap"]
    found = [*wraps, *(finding for finding in found if finding not in wraps)]
    usable = not any(finding.about == "units" for finding in found)
    if as_json:
        document(json_text(_json(usable, logs, found), indent=1) + "\n")
    else:
        stop = ["`rwjax fit` would stop here and ask; `--force` goes on even so"]
        lines = [f"- {finding.about}: {finding}" for finding in found] or [
            "nothing odd was found; how far the model is from these logs is another question"
        ]
        ahead = _ahead(rig, rig_file, dict(zip(log_files, logs, strict=True)), found)
        say("\n".join([*map(str, logs), "", *lines, *(ahead if usable else stop)]))
    if not usable:
        asked = next(finding for finding in found if finding.about == "units")
        first = wraps[0] if wraps else asked
        raise InputError(f"{rig_file}: {first if as_json else UNWRAP if wraps else SETTLE}")


def _ahead(rig: "Rig", rig_file: Path, logs: "Mapping[Path, Log]", found: "Sequence[Finding]") -> list[str]:
    """What comes next, of logs about which there is no question: to mend them, to record others, or to use them."""
    if mended := sorted({finding.log for finding in found if finding.kind in MENDED}):
        command = "fit" if rig.free else "diagnose"
        other = "" if any(finding.kind == "wrap" for finding in found) else OR_AS_THEY_ARE.format(command)
        return [f"{MEND} in {listed(mended)}, then check again{other}", next_command("check", rig_file, *logs)]
    if any(finding.kind == "nothing_told" for finding in found):
        return [] if rig.kind == "two_axis" else [next_command("plan", rig_file, *_largest(rig, [*logs.values()]))]
    read = [path for path, log in logs.items() if log.outputs]
    if not read:
        return [next_command("predict", rig_file, next(iter(logs)))]
    if all(logs[path].validate for path in read):
        every = "every one" if len(read) == len(logs) else "every one with readings"
        return [f"no log to fit on: {every} is marked `# role: validate`; give one without that line"]
    return [next_command("fit" if rig.free else "diagnose", rig_file, *read)]


def _largest(rig: "Rig", logs: "Sequence[Log]") -> list[str]:
    """The option of `plan` that says how large its commands may be, where the rig file does not."""
    if any(log.input == GOAL for log in logs):
        return ["--goal", "ANGLE"]
    return [] if rig.pwm is not None or "drive.supply" in rig.numbers else ["--volts", "VOLTS"]


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
