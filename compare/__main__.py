"""`python -m compare`: the command `femic`."""

from compare.cli.main import main

main()
