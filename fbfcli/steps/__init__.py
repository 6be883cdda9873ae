"""Step pulses of motors: when each comes, and the files that hold them."""
