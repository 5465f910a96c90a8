"""Whole runs against segments on measured pendulums that no free run follows."""
