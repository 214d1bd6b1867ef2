"""The command line `femic`, which may import everything else."""
