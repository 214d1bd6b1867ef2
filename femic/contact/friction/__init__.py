"""Friction: Coulomb's law on a grid, how surfaces slip, contact with normal and tangential tractions."""
