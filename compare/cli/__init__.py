"""The command line `femic`: the top floor of `compare`."""
