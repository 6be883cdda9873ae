"""Error: the firmware, the plant and the path, executed."""
