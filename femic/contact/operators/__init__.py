"""IC matrices as operators from tractions to displacements on a grid, by fast Fourier transforms."""
