"""Meshing for both engines: outlines of sections, sizes of cells, sessions of Gmsh."""
