"""The rig file: what the user believes about the hardware, read, checked and written."""
