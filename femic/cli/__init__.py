"""The command line `femic`, which may import all other parts of `compare`."""
