"""Comparisons: studies, campaigns, validation, and a page for each question.

It may import `geometries`, `approx` and `femic`, of which only the command line, `femic.cli`, imports it.
`femic` hands out some names from here when they are used.
"""
