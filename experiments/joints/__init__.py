"""Joints and servos: do the 95 % intervals of a fit hold the truth, where another simulator made the logs?

* `draw`: random joints with a voltage, a duty, a goal, a goal with the torque off for a while. Their truth is `experiments/blind/joint.py`.
* `run`: fits each, and counts.
"""
