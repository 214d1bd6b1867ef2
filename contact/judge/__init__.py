"""The judge: frictionless contact of two meshed bodies, without any influence coefficients."""
