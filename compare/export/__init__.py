"""`femic export` writes the IC matrix of a scene as a file of the program CONTACT."""
