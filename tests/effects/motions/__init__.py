"""Motions of effects known in closed form: every module here holds a list `MOTIONS`."""
