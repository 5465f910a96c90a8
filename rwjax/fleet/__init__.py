"""Many rigs: a command for each of them on Dask, and which of them changed.

From Python, `rwjax.fleet.plan.read_plan` reads a plan, `rwjax.fleet.run.run` carries it out, and `rwjax.fleet.changes.changes` says which
rig differs from its siblings or from itself.
"""

FALSE = 0.05
"""Share of the alarms that may be false, on average [1]."""
