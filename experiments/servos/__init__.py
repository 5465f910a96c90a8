"""Measured servo joints: a goal followed by the model's own position, against the measured error fed in as a voltage."""
