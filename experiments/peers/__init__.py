"""What other tools make of the same measured rig: held-out error, time, lines to write, and what each says of the cause."""
