"""The run of a campaign: its tasks, the cluster that executes them, and the plan of what that would take."""
