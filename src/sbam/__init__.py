"""SBAM: teach a two-armed robot a task by showing it a few times."""
