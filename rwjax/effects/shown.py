"""Kinds of run in a campaign, each with what it shows: an effect names those that show it."""

COASTING = "coasting"
FAST = "fast"
SLOW = "slow"
LEVELS = "levels"
DWELLING = "dwelling"

RUNS = {
    COASTING: "coast-downs from several rates, forward and backward",
    FAST: "commands that change faster than the drive and the couplings follow",
    SLOW: "triangles through standstill",
    LEVELS: "a staircase up to the largest command",
    DWELLING: "a staircase of small commands, with rest and breakaway",
}
"""What the rig does in each kind of run."""
