"""Where the robot's base may stand: from a task to the places from which both hands reach all of it."""
