"""What the models of a scene take: unknowns, seconds, memory."""
