"""`femic fe-contact`: figures and page of contact by finite elements and by ICs."""
