"""ICs as operators from tractions to displacements on a grid, computed by fast Fourier transforms."""
