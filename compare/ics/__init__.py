"""`femic run` computes the ICs of a scene along its lines; `femic show` draws fields in 3D."""
