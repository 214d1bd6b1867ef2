"""How a profile was understood, as a page: its points, the smooth curve, its inclination and curvature."""
