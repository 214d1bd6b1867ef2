"""Maps: C, and fits of B-hat-prime, interpolated between the scenes of a campaign."""
