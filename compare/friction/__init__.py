"""`femic contact`: figures and pages of motions with friction by several ICs."""
