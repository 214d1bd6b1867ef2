"""The harmonic engine: a section in quartic triangles, one problem per wavenumber along x."""
