"""Effects that few rigs of a fleet have, by their diagnoses: what their siblings do not lack, and they themselves did not before."""

import polars as pl

from rwjax.diagnosis.verdict import CLAIMS

FEW = 0.5
"""Share of the rigs up to which an effect is one of few [1]."""


def appeared(rows: pl.DataFrame) -> pl.DataFrame:
    """The effects that few rigs have in their latest session.

    Args:
        rows: Results of diagnoses (`rwjax.fleet.store.schema`).

    Returns:
        One effect, or one set, a line: `rig`, `when`, `effect` as the diagnosis names it first, how many `siblings` have it in their
        latest session, `of` how many.
    """
    claimed = rows.filter(pl.col("status") == "done", pl.col("verdict").is_not_null())
    named = claimed.with_columns(
        effect=pl.when(pl.col("verdict").is_in(list(CLAIMS))).then(pl.col("effects").list.get(0, null_on_oob=True))
    ).sort("rig", "when")
    last = named.group_by("rig", maintain_order=True).agg(
        pl.col("when").last(), pl.col("effect").last(), pl.col("effect").slice(0, pl.len() - 1).alias("before")
    )
    of = last.height
    counted = last.drop_nulls("effect").with_columns(siblings=pl.len().over("effect"))
    few = counted.filter((pl.col("siblings") <= FEW * of) & ~pl.col("before").list.contains(pl.col("effect")))
    return few.select("rig", "when", "effect", pl.col("siblings").cast(pl.Int64), pl.lit(of, pl.Int64).alias("of"))
