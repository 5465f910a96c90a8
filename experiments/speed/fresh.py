"""One fit in a process of its own: from its start to the fitted numbers, by stages, as JSON.

`fitted at` is read off the clock that all processes share, so that who started this one knows how long that took.
"""

import time

BEGIN = time.perf_counter()

import json  # noqa: E402
import sys  # noqa: E402


def main(folder: str) -> None:
    """Reads `rig.toml` and `log.csv` of a folder and fits."""
    from rwjax import read_log, read_rig
    from rwjax.fitting.fit import fit

    imported = time.perf_counter()
    rig = read_rig(f"{folder}/rig.toml")
    record = read_log(f"{folder}/log.csv", rig)
    read = time.perf_counter()
    found = fit(rig, [record])
    fitted, clock = time.perf_counter(), time.monotonic()
    fit(rig, [record])
    again = time.perf_counter()
    print(
        json.dumps(
            {
                "import": imported - BEGIN,
                "read": read - imported,
                "first fit": fitted - read,
                "second fit": again - fitted,
                "fitted at": clock,
                "cost": found.fit.cost,
            }
        )
    )


if __name__ == "__main__":
    main(sys.argv[1])
