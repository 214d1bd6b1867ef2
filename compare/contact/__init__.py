"""`femic contact`: figures and pages of contact by several ICs."""
