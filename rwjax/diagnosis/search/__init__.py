"""Which effects are missing: strategies from fits and candidates to a choice."""
