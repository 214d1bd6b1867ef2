"""Reference influence coefficients (C) by finite elements: both engines, discount, estimates, matrices."""
