"""The expected cost of the models of a scene: unknowns, seconds, memory."""
