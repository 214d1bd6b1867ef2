"""What both engines mesh with: outlines of sections, sizes of cells, sessions of Gmsh."""
