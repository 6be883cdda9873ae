"""Path distance s, then time t: how a firmware plans and how a trajectory is sampled."""
