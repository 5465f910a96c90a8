"""What is odd about a log by itself, before any model is asked: clock, command, readings, and a loop that closes over them."""

from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from rwjax.errors import counted, in_two_digits
from rwjax.kinds import GOAL, is_angle
from rwjax.logs.dropouts import dropouts, equal_stretches, freezes, leaps_after_rests, without_dropouts
from rwjax.logs.leaps import leaps
from rwjax.logs.log import Log
from rwjax.logs.noise import noise_by_output
from rwjax.rig.columns import unit_of

GAP, UNEVEN, DRIFTS = 5.0, 0.2, 0.01
"""Interval over the median one that is a gap; scatter of the others, and change from begin to end, over the median [1]."""
BURSTS, REGULAR, PAUSES = 5, 0.1, 2.0
"""Gaps from which a log may be recorded in bursts; how far the lengths of these, and the times between them, may differ; the longest gap over
the median one, beyond which that one has to be told [1, 1, 1]."""
MOST_NOTED = 3
"""Logs that lack rows which are told of one by one beside a result."""
LOST, FEW = 1.5, 0.1
"""Interval over the median one from which a row is lost between even ones; share of the intervals up to which it is rows, and not the rate [1]."""
AT_LIMIT, MANY, CLOSE = 0.1, 20, 0.8
"""Share of the samples at the largest command, beside as many other values, from which it is clipped, if it comes from as near."""
MISSING = 0.01
"""Share of missing readings worth a word [1]."""
FROZEN = 10
"""Equal readings in a row of a sensor whose readings otherwise differ."""
COARSE = 0.01
"""Smallest change of a reading, in its large ones, from which a sensor counts as one in steps, which a rest leaves at one reading [1]."""
STEPS, SLOW = 5, 1e-3
"""Readings by which a motion without noise is seen to come to rest or to begin; size of a step, in large ones, that is hardly a motion [1]."""
SETTLED = 0.01
"""Range of a command at the end of a run, over its range in the run, up to which it has settled [1]."""
COUNTERS = {256: "8-bit", 4096: "12-bit", 16384: "14-bit", 65536: "16-bit"}
"""Counts after which a counter begins again."""
NEAR = 0.1
"""Share of a counter's length by which a jump may differ from it [1]."""
MOVES = 10.0
"""Range of readings, in standard deviations of their noise, below which they hardly move [1]."""
STEP, AT_REST, MOVES_OFF, WITHIN_S = 0.1, 0.02, 0.1, 0.5
"""First command over the largest from which a log begins with a step; speed over the largest up to which a rig rests at first, and from
which it has moved off; time by which it has, so that it is no friction that holds it [1, 1, 1, s]."""
SEEN = 3.0
"""Noise levels, or counts, above which a reading differs from rest [1]."""
PAST, LAGS, FED_BACK = 20, 3, 0.3
"""Samples from which the next is predicted, samples after which a loop may answer, and correlation from which it does."""


class Finding(NamedTuple):
    """Something odd about a log.

    Attributes:
        log: Name of the log, "" for all of them.
        about: "clock", "command", "readings", "loop", "units" or "numbers".
        says: What it is and what to do, one sentence.
        kind: "gaps", "bursts", "missing_rows", "uneven" or "drift" of a clock; "constant", "clipped", "one_way" or "begins_driven" of a
            command; "missing", "outliers", "dropout", "frozen", "leap", "wrap" or "still" of readings; "loop"; "question" about units;
            "guessed", "nothing_told" or "barely_told" of numbers.
    """

    log: str
    about: str
    says: str
    kind: str

    def __str__(self) -> str:
        """Log and sentence."""
        return f"{self.log}: {self.says}" if self.log else self.says


def findings(log: Log) -> list[Finding]:
    """What is odd about a log by itself.

    Args:
        log: The log.

    Returns:
        The findings; none for a log as it should be.
    """
    dropped = dropouts(log)
    read = without_dropouts(log, dropped)
    froze = [freeze for freeze in freezes(read) if _frozen(read, freeze.output) is None]
    moved = without_dropouts(read, froze)
    found = {
        "command": (*_about_command(log), *_about_start(read)),
        "readings": (
            *_about_missing(log),
            *(("dropout", dropout.says) for dropout in dropped),
            *(("frozen", freeze.says) for freeze in froze),
            *_about_readings(moved),
        ),
        "loop": _about_loop(without_dropouts(moved, leaps_after_rests(moved))),
    }
    return [
        *gaps_in_time(log),
        *(Finding(log.name, "clock", says, kind) for kind, says in _about_clock(log)),
        *missing_rows(log),
        *(Finding(log.name, about, says, kind) for about, of in found.items() for kind, says in of),
    ]


def missing_rows(log: Log) -> list[Finding]:
    """Rows that are missing between even ones while the command changes: whatever simulates the log holds the command there.

    Args:
        log: The log.

    Returns:
        One finding with how many rows, and after which time [s] the first; none where no row is missing, or where the command is held anyway.
    """
    if len(log.time) < 2:
        return []
    step = np.diff(log.time)
    usual = float(np.median(step))
    lost = np.flatnonzero((step > LOST * usual) & (step <= GAP * usual))
    evenly = np.std(step[step <= LOST * usual]) <= UNEVEN * usual
    if not (evenly and 0 < len(lost) <= FEW * len(step) and np.mean(_changes(log)) > 0.5):
        return []
    rows = int(np.sum(np.round(step[lost] / usual) - 1.0))
    says = (
        f"{counted(rows, 'row')} {'is' if rows == 1 else 'are'} missing, the first after {log.time[lost[0]]:.6g} s: the command changes at "
        "most samples, and counts as held there; write these rows with their command, readings empty"
    )
    return [Finding(log.name, "clock", says, "missing_rows")]


def gaps_in_time(log: Log) -> list[Finding]:
    """Times without a sample, longer than a few lost rows: whatever simulates the log holds the command there, too.

    Args:
        log: The log.

    Returns:
        One finding with how many there are, and where [s] the longest one is, or for a log that was recorded in bursts with how long these
        are and how often [s] they come; none for a log without any.
    """
    step = np.diff(log.time)
    gaps = np.flatnonzero(step > GAP * np.median(step)) if len(step) else step
    if not len(gaps):
        return []
    k = int(gaps[np.argmax(step[gaps])])
    changed = int(np.sum(_changes(log)[gaps]))
    where = "it" if len(gaps) == 1 else f"{changed} of {len(gaps)}"
    known = (
        f"after {where} the command is another one, and when it changed"
        if changed
        else "whether it changed and came back"
    )
    bursts = _bursts(log.time, gaps)
    what = bursts or f"{counted(len(gaps), 'gap')} in time, the longest {step[k]:.3g} s at {log.time[k]:.6g} s"
    split = "" if bursts else "split the log, or "
    says = (
        f"{what}: the command counts as held {'between them' if bursts else 'there'}; {known} is not known; where it was not held, "
        f"{split}write these rows with their command, readings empty"
    )
    return [Finding(log.name, "clock", says, "bursts" if bursts else "gaps")]


def _bursts(time: np.ndarray, gaps: np.ndarray) -> str:
    """How a log with regular gaps was recorded: how many readings at a time, and how often; "" for any other."""
    if len(gaps) < BURSTS:
        return ""
    many, every = np.diff(gaps), np.diff(time[gaps + 1])
    usual, seconds = float(np.median(many)), float(np.median(every))
    margin, lasts = max(REGULAR * usual, 1.0), np.diff(time)[gaps]
    cut_short = max(gaps[0] + 1, len(time) - 1 - gaps[-1]) <= usual + margin  # the first and the last one may be
    regular = np.abs(many - usual).max() <= margin and np.abs(every / seconds - 1.0).max() <= REGULAR
    regular &= cut_short and lasts.max() <= PAUSES * np.median(lasts)
    return f"recorded in bursts of {usual:.0f} readings every {seconds:.3g} s" if regular else ""


def leaping(log: Log, outputs: Collection[str]) -> list[str]:
    """What is said of angles that leap and do not wrap.

    Args:
        log: The log, without outliers and drop-outs.
        outputs: Names of outputs; those that the log does not hold do not count.

    Returns:
        A sentence for each leap.
    """
    held = [name for name in log.outputs if name in outputs and not [*_wrapped(log, name)]]
    return [leap.says for name in held for leap in leaps(log, name)]


def holes(logs: Sequence[Log]) -> list[str]:
    """Where logs lack rows, few or many in a row, as notes beside a result.

    Args:
        logs: The logs.

    Returns:
        A sentence for each log that lacks some; one for all of them where they are more than `MOST_NOTED`.
    """
    lacking = [found for log in logs if (found := [*missing_rows(log), *gaps_in_time(log)])]
    if len(lacking) <= MOST_NOTED:
        return [str(found[0]._replace(says="; and ".join(one.says for one in found))) for found in lacking]
    return [
        f"{len(lacking)} of {counted(len(logs), 'log')} lack rows, {lacking[0][0].log} first: the command counts as held there, and whether it "
        "changed there is not known; `rwjax check` says where"
    ]


def _about_clock(log: Log) -> Iterator[tuple[str, str]]:
    """Uneven intervals, and a clock that changes its rate."""
    step = np.diff(log.time)
    usual = float(np.median(step))
    even = step[step <= GAP * usual]
    if np.std(even) > UNEVEN * usual:
        yield (
            "uneven",
            f"samples lie {1e3 * np.min(even):.3g} to {1e3 * np.max(even):.3g} ms apart, {1e3 * usual:.3g} in the median: if the logger "
            "samples evenly, the time stamps are late, and evenly spaced ones are better",
        )
    quarter = len(even) // 4
    if quarter >= PAST:
        first, last = float(np.mean(even[:quarter])), float(np.mean(even[-quarter:]))
        if abs(last - first) > DRIFTS * usual and np.std(even) < UNEVEN * usual:
            yield (
                "drift",
                f"the interval goes from {1e3 * first:.4g} to {1e3 * last:.4g} ms over the run: does the clock drift?",
            )


def _changes(log: Log) -> np.ndarray:
    """Whether a command differs from that of the sample before (n − 1,)."""
    return np.any(np.diff(log.command.reshape(len(log.command), -1), axis=0) != 0.0, axis=1)


def _about_command(log: Log) -> Iterator[tuple[str, str]]:
    """A command that never changes, goes one way, or is clipped."""
    unit = unit_of(log.input)
    for k, u in enumerate(log.command.reshape(len(log.command), -1).T):
        name = log.input if log.command.ndim == 1 else f"voltage_{k + 1}_V"
        low, high = float(u.min()), float(u.max())
        if low == high:
            yield (
                "constant",
                f"{name} is {low + 0.0:g} throughout: it tells friction at most, or how the rig swings about a rest; add runs in which it changes",
            )
            continue
        size, values = max(abs(low), abs(high)), len(np.unique(u))
        at_limit = _clipped(u, size)
        if name != GOAL and values > MANY and at_limit > AT_LIMIT:
            yield (
                "clipped",
                f"{name} is at its largest, {size:.4g} {unit}".rstrip()
                + f", in {100 * at_limit:.0f} % of the samples beside {values - 1} other values: where the drive clips it, log what "
                "is left of it, or let the rig file clip it, too",
            )
        if name != GOAL and (low >= 0.0 or high <= 0.0):
            way = "below" if low >= 0.0 else "above"
            yield (
                "one_way",
                f"{name} never goes {way} 0: nothing is told of the other direction; add a run that reverses it",
            )


def _about_start(log: Log) -> Iterator[tuple[str, str]]:
    """A log that begins with a step from rest: a drive that acts late is taken to have had the first command for long."""
    if log.input == GOAL or log.enabled is not None:
        return
    given = np.abs(log.command.reshape(len(log.command), -1))
    if not np.any(given[0] > STEP * given.max(axis=0)):
        return
    for name in log.outputs:
        if not name.startswith("current") and _moves_off(log, name):
            yield (
                "begins_driven",
                f"the command is not 0 at the first sample, and {name} begins at rest: a drive that acts late counts as settled by then; "
                "where the command was 0 before, write a row with 0 before the first one, readings empty",
            )
            return


def _moves_off(log: Log, name: str) -> bool:
    """Whether a motion begins at rest with the log and moves off soon."""
    seen = np.isfinite(log.outputs[name])
    time, y = log.time[seen], log.outputs[name][seen]
    if not seen[0] or len(y) < FROZEN:
        return False
    noise = SEEN * max(noise_by_output(log)[name], log.resolution.get(name, 0.0))
    speed = np.abs(np.diff(y) / np.diff(time)) if is_angle(name) else np.abs(y)
    least = noise / np.median(np.diff(time)) if is_angle(name) else noise
    largest = float(speed.max())
    soon = speed[time[: len(speed)] <= time[0] + WITHIN_S]
    return bool(speed[0] <= max(AT_REST * largest, least) < MOVES_OFF * largest <= soon.max())


def _clipped(u: np.ndarray, size: float) -> float:
    """Share of the samples at the largest command [1], 0 where it mostly gets there by a leap."""
    at = np.isclose(np.abs(u), size, rtol=1e-6)
    before = np.abs(u[np.flatnonzero(at[1:] & ~at[:-1])])
    return float(np.mean(at)) if len(before) and np.mean(before > CLOSE * size) > 0.5 else 0.0


def _about_missing(log: Log) -> Iterator[tuple[str, str]]:
    """Missing and outlying readings."""
    for name, y in log.outputs.items():
        out = len(log.left_out.get(name, ()))
        seen = np.isfinite(y)
        missing = int((~seen).sum()) - out
        if missing > MISSING * len(y):
            gap = int(np.argmax(~seen))
            yield (
                "missing",
                f"{name}: {missing} of {len(y)} readings are missing, the first at {log.time[gap]:.6g} s: is the sensor read every time?",
            )
        if out:
            first = float(log.left_out[name][0])
            if first == log.time[-1]:
                says = (
                    f"the last reading, at {first:.6g} s, is an outlier and not counted: where the recording broke off within that "
                    "number, delete the last line, else look at the wiring"
                )
            else:
                says = f"{counted(out, 'outlier')}, the first at {first:.6g} s, not counted; look at the wiring"
            yield "outliers", f"{name}: {says}"


def _about_readings(log: Log) -> Iterator[tuple[str, str]]:
    """Frozen and wrapped readings, and those that hardly move."""
    noise = noise_by_output(log)
    for name, y in log.outputs.items():
        seen = np.isfinite(y)
        yield from _wrapped(log, name)
        yield from (("leap", says) for says in leaping(log, (name,)))
        if frozen := _frozen(log, name):
            k, many = frozen
            lasts = log.time[k + many - 1] - log.time[k]
            yield (
                "frozen",
                f"{name} stays the same for {lasts:.3g} s from {log.time[k]:.6g} s on, and differs from sample to sample elsewhere: "
                "a dropout? Leave those cells empty",
            )
        if float(np.ptp(y[seen])) < MOVES * noise[name]:
            times = in_two_digits(float(np.ptp(y[seen])) / noise[name])
            yield (
                "still",
                f"{name} hardly moves, by {times} times its noise: drive the rig harder, or leave the column out",
            )


def _wrapped(log: Log, name: str) -> Iterator[tuple[str, str]]:
    """Jumps of an angle by a counter's length or by a turn."""
    seen = np.isfinite(log.outputs[name])
    y, step = log.outputs[name][seen], np.diff(log.time[seen])
    if not is_angle(name) or len(y) < 2:
        return
    count = log.resolution.get(name, 0.0)
    jump = np.abs(np.diff(y))[step <= GAP * np.median(step)] / (count or 1.0)  # it may turn as far in a gap
    usual = float(np.quantile(jump, 0.9))
    turn = 2.0 * np.pi / (count or 1.0)
    lengths = {float(many): f"{bits} counter" for many, bits in COUNTERS.items()} if count else {}
    for length, of in (lengths | {turn: "turn", 0.5 * turn: "half turn"}).items():
        hits = int(np.sum(np.abs(jump - length) < NEAR * length))
        if hits and usual < NEAR * length:
            shown = f"{length:.0f} counts" if count else f"{length:.4g} rad"
            yield (
                "wrap",
                f"{name} jumps by {shown}, a {of}, {hits} times: it wraps; unwrap it first (numpy.unwrap(…, period=…))",
            )
            return


def _frozen(log: Log, name: str) -> tuple[int, int] | None:
    """First sample and length of the longest stretch of equal readings of a sensor in SI whose readings differ otherwise."""
    y = log.outputs[name]
    same = np.diff(y) == 0.0
    if log.resolution.get(name, 0.0) or not same.any() or np.mean(same) > 0.5:
        return None
    stretches = equal_stretches(y)
    usual = float(np.median(np.sort(np.diff(stretches)[:, 0])[:-1])) + 1.0 if len(stretches) > 1 else 1.0
    for first, last in stretches[np.argsort(stretches[:, 0] - stretches[:, 1], kind="stable")]:
        many = int(last - first) + 1
        if many < max(FROZEN, 5.0 * usual):
            return None
        off = log.enabled is not None and not np.any(
            log.enabled[first : last + 1]
        )  # an arm that is let go comes to rest
        if not off and not _rests(log, name, int(first), int(last)):
            return int(first), many
    return None


def _rests(log: Log, name: str, first: int, last: int) -> bool:
    """Whether an output that stays the same between two samples rests there.

    It goes on without a leap. Its logged speed, which moves elsewhere, is 0 for most of that time; or it comes to rest and begins again
    smoothly, as in a simulation without noise; or its readings are coarse and go on by a step, or have come there so by the end of the run,
    under a command that has settled.
    """
    jump = np.abs(np.diff(log.outputs[name]))
    moving = jump[jump > 0.0]
    if not len(moving):
        return True
    large = float(np.quantile(moving, 0.9))
    if last < len(jump) and not jump[last] <= large:
        return False
    speed = log.outputs.get(f"{name}_s") if is_angle(name) else None
    if speed is not None:
        within = np.isin(np.arange(len(speed)), np.arange(first, last + 1))
        if np.mean(speed[within] == 0.0) > 0.5 and np.mean(speed[~within] != 0.0) > 0.5:
            return True
    if _slows_and_begins(np.diff(log.outputs[name]), first, last, SLOW * large):
        return True
    if float(np.min(moving)) <= COARSE * large:
        return False
    if last < len(jump):
        return True
    changes = np.ptp(log.command[first : last + 1], axis=0)
    return bool(jump[first - 1] <= large) and bool(np.all(changes <= SETTLED * np.ptp(log.command, axis=0)))


def _slows_and_begins(steps: np.ndarray, first: int, last: int, slow: float) -> bool:
    """Whether a motion slows to a rest between two samples and gets up from it, as far as there are readings before and after.

    Away from the rest its steps have one sign and grow, at least twofold within `STEPS`: noise does not do so, nor a motion that a sensor
    leaves out. Or they are `slow`.
    """
    sides = [side for side in (steps[:first][::-1][:STEPS], steps[last : last + STEPS]) if len(side)]
    sizes = [np.abs(side) for side in sides]
    grows = [
        abs(int(np.sum(np.sign(side)))) == STEPS and np.all(np.diff(size) >= 0.0) and 2.0 * size[0] <= size[-1]
        for side, size in zip(sides, sizes, strict=True)
    ]
    return all(up or bool(np.all(size <= slow)) for up, size in zip(grows, sizes, strict=True))


def _about_loop(log: Log) -> Iterator[tuple[str, str]]:
    """A command that answers the readings, by what in each is new."""
    if log.input == GOAL or log.command.ndim > 1:
        return
    for name, y in log.outputs.items():
        if name.startswith("current"):
            continue
        seen = np.isfinite(y)
        if frozen := _frozen(log, name):  # a jump to where the readings would be answers nothing
            seen[frozen[0] : sum(frozen)] = False
        whole = _without_gap(log.time, seen)
        given, read = _new(log.command, whole), _new(y, whole)
        lags = range(0 if is_angle(name) else 1, LAGS + 1)
        answer = max((abs(_correlation(given[lag:], read[: len(read) - lag])) for lag in lags), default=0.0)
        if answer > FED_BACK and answer > 4.0 / np.sqrt(max(whole.sum(), 1)):
            yield (
                "loop",
                f"{log.input} answers {name} (correlation {answer:.2f} of what is new in each): a loop was closed; log its goal and give "
                "[drive.servo], or add a command of your own to it, since noise that is fed back bends a fit",
            )
            return


def _without_gap(time: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Which samples were read and have the `PAST` before them, without a gap in time or in the readings (n − PAST,): nothing follows across one."""
    step = np.diff(time)
    gaps = np.append(0, np.cumsum((step > GAP * np.median(step)) | ~seen[1:]))
    return (gaps[PAST:] == gaps[:-PAST]) & seen[:-PAST]


def _new(y: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """What in each sample does not follow from the `PAST` before (n − PAST,), 0 for a sample whose past is not whole."""
    n, now = len(whole), y[PAST:][whole]
    new = np.zeros(n)
    if len(now) < 5 * PAST or not np.ptp(now):
        return new
    before = np.stack([np.ones(n), *(y[PAST - k : PAST - k + n] for k in range(1, PAST + 1))], axis=1)[whole]
    rest = now - before @ np.linalg.lstsq(before, now, rcond=1e-10)[0]
    new[whole] = rest if np.std(rest) > 1e-6 * np.std(now) else 0.0
    return new


def _correlation(a: np.ndarray, b: np.ndarray) -> float:
    """Correlation of two signals, 0 where one of them is constant."""
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size > 0.0 else 0.0
