"""`femic contact`: figures and pages of rolling and compression with friction by several ICs."""
