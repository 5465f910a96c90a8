"""What a worker does: the command for the logs of one rig, as a row of the results, whatever becomes of it."""

import os
import zlib
from collections.abc import Callable, Mapping, Sequence
from math import hypot, inf, isfinite, sqrt
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from rwjax.errors import InputError, one_line
from rwjax.fleet.plan import Job

if TYPE_CHECKING:
    from rwjax.logs.log import Log
    from rwjax.rig.model import Rig

Row = dict[str, Any]
"""A row of the results, by `rwjax.fleet.store.schema`."""
AS_GOOD = 1.01
"""RMS error over that of the best method up to which a method is as good [1]; of such the first in the table of methods is taken."""
NO_METHOD = "no method"
"""Verdict of a comparison where no method's model is stable."""
NOTHING = "the logs tell nothing"
"""Verdict of a fit or a comparison of logs in which none of the free numbers leaves a trace."""
END_TO_END = "end-to-end"
"""Name of the method that any logs suit (`rwjax.methods.comparison.METHODS`)."""


def on_worker(job: Job, command: str, options: Mapping[str, Any], folder: str) -> Row:
    """The row of a job, in a process that is one of many: threads of its own would take the others' cores.

    Args:
        job: As `carried_out` has it.
        command: The same.
        options: The same.
        folder: The same.

    Returns:
        The row.
    """
    os.environ.setdefault("RWJAX_THREADS", "1")  # `rwjax.fitting.threads.VARIABLE`, which reads it when it is imported
    return carried_out(job, command, options, folder)


def carried_out(job: Job, command: str, options: Mapping[str, Any], folder: str) -> Row:
    """The row of a job.

    Args:
        job: Its rig and its logs.
        command: A key of `rwjax.fleet.plan.OPTIONS`.
        options: Options of the command.
        folder: Folder for the reports of diagnoses, one for each job.

    Returns:
        The row. What goes wrong stands in it as `line`, and `status` is `failed`.
    """
    begin, row = perf_counter(), failed(job, command, "")  # with the files as they are before they are read
    try:
        found = {"status": "done"} | COMMANDS[command](job, options, folder)
    except InputError as error:
        found = {"status": "failed", "line": one_line(str(error))}
    except Exception as error:  # reason: one rig of thousands; the others go on
        found = {"status": "failed", "line": one_line(f"{type(error).__name__}: {error}")}
    return row | {"line": None} | found | {"seconds": perf_counter() - begin}


def failed(job: Job, command: str, line: str) -> Row:
    """The row of a job that came to nothing.

    Args:
        job: The job.
        command: The command.
        line: Why, in one line.

    Returns:
        The row.
    """
    of = {"rig": job.rig, "when": job.when, "command": command, "inputs": job.inputs()}
    return of | {"status": "failed", "line": line, "seconds": None}


def report_folder(job: Job) -> str:
    """Folder of a job's report, below that of the reports.

    Args:
        job: The job.

    Returns:
        A relative path: the rig, and below it the session where it has a name. What no file's name may hold stands as `_`, and then a
        number of the name keeps it apart from others.
    """
    return "/".join(_plain(part) for part in (job.rig, job.when) if part)


def _plain(name: str) -> str:
    """A name as a folder's."""
    plain = "".join(c if c.isalnum() or c in "-_.+" else "_" for c in name).strip(".")
    return plain if plain == name else f"{plain}-{zlib.crc32(name.encode('utf-8', 'surrogatepass')):08x}"


def _read(job: Job, options: Mapping[str, Any]) -> "tuple[Rig, Sequence[Log]]":
    """Rig and logs, which are asked about unless the options say `force`."""
    from rwjax.fitting.questions.ask import questions
    from rwjax.fitting.segments import with_segments
    from rwjax.logs.read import read_logs
    from rwjax.rig.read import read_rig

    rig = read_rig(job.rig_file)
    logs = with_segments(rig, read_logs(list(map(Path, job.logs)), rig), options.get("segments"))
    if not options.get("force") and (found := questions(rig, logs)):
        raise InputError("; ".join([*found, "`force = true` in [options] goes on even so"]))
    return rig, logs


def _fit(job: Job, options: Mapping[str, Any], folder: str) -> Row:
    from rwjax.fitting.fit import fit
    from rwjax.fitting.ran_away import runaway_words
    from rwjax.report.answer import json_text

    rig, logs = _read(job, options)
    result = fit(rig, logs)
    if not options.get("force") and (words := runaway_words(rig, result.rig)):
        raise InputError("; ".join(words))
    found = result.json()
    if not options.get("force") and not result.tells_something:
        return {"verdict": NOTHING, "answer": json_text(found)}
    ratios = [(rms / found["noise"][name]) ** 2 for name, rms in found["rms"].items() if found["noise"].get(name)]
    return _numbers(found) | {"misfit": sqrt(sum(ratios) / len(ratios)) if ratios else None, "answer": json_text(found)}


def _check(job: Job, options: Mapping[str, Any], folder: str) -> Row:
    from rwjax.fitting.questions.check import check
    from rwjax.logs.read import read_logs
    from rwjax.report.answer import json_text
    from rwjax.rig.read import read_rig

    rig = read_rig(job.rig_file)
    found = check(rig, read_logs(list(map(Path, job.logs)), rig, outputs_required=False))
    usable = not any(finding.about == "units" for finding in found)
    answer = {"usable": usable, "findings": [finding._asdict() for finding in found]}
    return {"verdict": "usable" if usable else "asks", "answer": json_text(answer)}


def _diagnose(job: Job, options: Mapping[str, Any], folder: str) -> Row:
    from rwjax.diagnosis.diagnosis import diagnose
    from rwjax.report.answer import json_text
    from rwjax.report.results import clear_results, write_results

    rig, logs = _read(job, options)
    names = {key: options.get(key, ()) for key in ("only", "without")}
    result = diagnose(rig, logs, budget=options.get("budget", inf), **names)
    found, own = result.json(), Path(folder, report_folder(job))
    try:
        own.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{own}: cannot make this folder ({error.strerror})") from None
    clear_results(own)
    write_results(result, own)
    gap = found["gap"]
    told = {key: gap[key] for key in ("signal", "before", "after", "floor", "closed")}
    sets = [found["effects"], *found["alternatives"]]
    return (
        _numbers(found)
        | told
        | {"verdict": found["verdict"], "effects": [" + ".join(one) for one in sets if one], "answer": json_text(found)}
    )


def _compare(job: Job, options: Mapping[str, Any], folder: str) -> Row:
    from rwjax.methods.comparison import compare
    from rwjax.report.answer import json_text

    rig, logs = _read(job, options)
    found = compare(rig, logs).json()
    if not any(one["rms"] for one in found["methods"]):
        raise InputError(f"no method can be used on these logs; {'; '.join(found['methods'][0]['notes'])}")
    told = options.get("force") or _tells_something(rig, logs, found)
    return (best_method(found) if told else {"verdict": NOTHING}) | {"answer": json_text(found)}


def _tells_something(rig: "Rig", logs: "Sequence[Log]", found: Mapping[str, Any]) -> bool:
    """Whether logs tell anything of the free numbers, as a fit says: at the estimates of the end-to-end method of a comparison."""
    from rwjax.fitting.fit import to_fit
    from rwjax.fitting.questions.numbers import tells_something

    fitted = {one["method"]: one["numbers"] for one in found["methods"]}.get(END_TO_END)
    if fitted is None:  # the method could not be used
        return True
    return tells_something(rig.with_values({name: one["value"] for name, one in fitted.items()}), to_fit(rig, logs))


def best_method(found: Mapping[str, Any]) -> Row:
    """The method of a comparison that follows the held-out data best, by its RMS errors over the floors.

    Args:
        found: A comparison (`rwjax.methods.comparison.Comparison.json`).

    Returns:
        The method as `verdict`, and of the output in which it stands furthest above the floor: the name (`signal`), the RMS error that it
        leaves (`after`) and that of a perfect model (`floor`) [SI].
    """
    floor = found["floor"]
    stable = {one["method"]: one["rms"] for one in found["methods"] if one["rms"] and None not in one["rms"].values()}
    if not stable:
        return {"verdict": NO_METHOD}
    outputs = next(iter(stable.values()))
    least = {name: min(rms[name] for rms in stable.values()) for name in outputs}
    unit = {name: floor[name] or least[name] or 1.0 for name in outputs}  # readings without noise have no floor
    over = {method: {name: e / unit[name] for name, e in rms.items()} for method, rms in stable.items()}
    whole = {method: hypot(*each.values()) for method, each in over.items()}
    best = next(method for method in over if whole[method] <= AS_GOOD * min(whole.values()))
    signal = max(over[best], key=over[best].__getitem__)
    return {"verdict": best, "signal": signal, "after": stable[best][signal], "floor": floor[signal]}


def _numbers(found: Mapping[str, Any]) -> Row:
    """Estimates and their covariance, of those that have a standard error."""
    told = [
        name for name in found["covariance_of"] if isfinite(found["numbers"].get(name, {}).get("standard_error") or inf)
    ]
    at = [found["covariance_of"].index(name) for name in told]
    return {
        "numbers": [{"name": name} | found["numbers"][name] for name in told],
        "covariance": [found["covariance"][j][k] for j in at for k in at],
    }


COMMANDS: dict[str, Callable[[Job, Mapping[str, Any], str], Row]] = {
    "fit": _fit,
    "check": _check,
    "diagnose": _diagnose,
    "compare": _compare,
}
"""What carries each command out: from a job, its options and the folder of the reports to columns of its row."""
