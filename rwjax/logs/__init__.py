"""Logs of a rig: read, checked, written, cut and split; their noise and their outliers."""
