"""Scenes, error measures, figures, reports and the command line `femic`.

May import all other packages; none of them imports this one.
"""
