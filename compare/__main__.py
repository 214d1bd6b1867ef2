"""`python -m compare`: the command `femic`."""

from compare.cli import main

main()
