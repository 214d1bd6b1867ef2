"""`femic run` and `femic show`: the ICs of a scene along its lines, fields in 3D."""
