"""The public interface, whose names `femic` has: it makes scenes of nouns in Python, and labels the results.

It contains no theory. Bodies, loads and settings become the tables of a scene, so that each key is declared
and checked in one place: arguments have the names of keys in scene files. Imports all packages below it.
"""
