"""Experiments for a rig: commands that the testbed's board plays, how far they move a rig, a campaign of them as files."""
