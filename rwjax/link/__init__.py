"""The line to the testbed's board: frames, sessions, recordings, live view."""
