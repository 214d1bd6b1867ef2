"""`femic contact`: figures and page of a scene's contact by several ICs."""
