"""From the sources of the firmware to a name: `python -m experiments.testbed.run [CASE…]`; every case without arguments.

Compiles the firmware, runs it in simavr with the testbed of a case hanging on it, records the campaign over the serial
protocol, and asks `rwjax diagnose` what the rig file lacks. Logs and reports stay in build/testbed/.
"""

import json
import shutil
import sys
import time
from pathlib import Path
from typing import Any

from experiments.testbed.campaign import RIG, campaign
from experiments.testbed.cases import CHANGES, expected, truth
from firmware.simavr.avr import missing
from rwjax.diagnosis.diagnosis import diagnose
from rwjax.logs.read import read_logs
from rwjax.report.html import write_report
from rwjax.rig.read import read_rig

OUTPUT = Path(__file__).resolve().parents[2] / "build" / "testbed"


def run(case: str) -> dict[str, Any]:
    """The diagnosis of a case, and the seconds that recording and diagnosing took."""
    folder, rig = OUTPUT / case, read_rig(RIG)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    start = time.perf_counter()
    logs = campaign(truth(case), folder, rig)
    recorded = time.perf_counter()
    result = diagnose(rig, read_logs(logs, rig))
    found = {**result.json(), "record_s": recorded - start, "diagnose_s": time.perf_counter() - recorded}
    (folder / "diagnosis.json").write_text(json.dumps(found, indent=1))
    write_report(result, folder)
    return found


def judged(case: str, found: dict[str, Any]) -> str:
    """How the answer compares with what is missing. `unknown` names nothing, whatever it says that helps."""
    right, named, verdict = expected(case), set(found["effects"]), found["verdict"]
    if verdict == "unknown" or (verdict == "none" and right):
        return "not named" if right else "wrong"
    if verdict == "ambiguous":
        options = [named, *map(set, found["alternatives"])]
        if right in options:
            return "named, with rivals" if named == right else "among the rivals"
    elif named == right:
        return "named"
    if right and right < named:
        return "named, and more"
    return "partly" if named & right else "wrong"


def row(case: str, found: dict[str, Any]) -> str:
    """One line of the table."""
    gap, also = found["gap"], [" + ".join(a) for a in found["alternatives"]]
    named = " + ".join(found["effects"]) or "-"
    closed = "-" if gap["closed"] is None else f"{100 * gap['closed']:.0f} %"
    seconds = f"{found['record_s']:.0f} + {found['diagnose_s']:.0f} s"
    rivals = f" (or {', '.join(also)})" if also else ""
    helps = " help" if found["verdict"] == "unknown" and found["effects"] else ""
    return f"| {case} | {judged(case, found)} | {found['verdict']}: {named}{helps}{rivals} | {closed} | {seconds} |"


def main(cases: list[str]) -> None:
    """Prints the table, a row as soon as it is there."""
    if unknown := [case for case in cases if case not in CHANGES]:
        sys.exit(f"no case {unknown[0]}; there are {', '.join(CHANGES)}")
    if packages := missing():
        sys.exit(f"needs the Debian packages {' '.join(packages)}")
    print("| missing | outcome | diagnosis | gap closed | record + diagnose |\n| --- | --- | --- | --- | --- |")
    for case in cases or CHANGES:
        print(row(case, run(case)), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
