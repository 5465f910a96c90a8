"""A simulator that shares no code with `rwjax`, and the labelled rigs and logs that it makes."""
