"""Pictures and self-contained pages that play a plan: from a trajectory to what a person can look at."""
