"""The timed joint trajectory: from a dense motion to samples within the limits, and the checks that they pass."""
