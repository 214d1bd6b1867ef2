"""`python -m femic`: the command `femic`."""

from femic.cli.main import main

main()
