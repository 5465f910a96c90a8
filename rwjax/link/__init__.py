"""The line to the testbed's board: frames, a session with the board, what it sends kept on disk, logs made of it."""
