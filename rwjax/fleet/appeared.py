"""Effects that few rigs of a fleet have, by their diagnoses: what their siblings do not lack, and they themselves did not before."""

from collections import Counter

import polars as pl

from rwjax.diagnosis.verdict import CLAIMS

FEW = 0.5
"""Share of the rigs up to which an effect is one of few [1]."""


def appeared(rows: pl.DataFrame) -> pl.DataFrame:
    """The effects that few rigs have in their latest session.

    Args:
        rows: Results of diagnoses (`rwjax.fleet.store.schema`).

    Returns:
        One effect a line: `rig`, `when`, `effect`, how many rigs have it in their latest session (`siblings`), `of` how many. An effect that
        stood in any set of an earlier session of the rig has not appeared.
    """
    sessions: dict[str, list[tuple[str, list[set[str]]]]] = {}
    diagnosed = rows.filter(pl.col("status") == "done", pl.col("verdict").is_not_null()).sort("rig", "when")
    for rig, when, verdict, sets in diagnosed.select("rig", "when", "verdict", "effects").iter_rows():
        claimed = [set(one.split(" + ")) for one in sets] if verdict in CLAIMS else []
        sessions.setdefault(rig, []).append((when, claimed))
    last = {rig: (own[-1][0], own[-1][1][0] if own[-1][1] else set()) for rig, own in sessions.items()}
    counts = Counter(effect for _, effects in last.values() for effect in effects)
    found = []
    for rig, (when, effects) in last.items():
        before = set().union(*(one for _, sets in sessions[rig][:-1] for one in sets))
        few = [effect for effect in sorted(effects - before) if counts[effect] <= FEW * len(last)]
        found += [(rig, when, effect, counts[effect], len(last)) for effect in few]
    columns = {**dict.fromkeys(("rig", "when", "effect"), pl.String), "siblings": pl.Int64, "of": pl.Int64}
    return pl.DataFrame(found, columns, orient="row")
