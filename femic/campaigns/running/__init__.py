"""The run of a campaign: its tasks, the cluster that executes them, and an estimate of the cost."""
