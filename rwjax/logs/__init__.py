"""Logs of a rig: read, checked, written, cut and split into folds; their noise and their outliers."""
