"""A wheelset on a track at several lateral shifts: its specification, its profiles in place, its contacts.

Imports contact and scenes. `femic.results.wheelset` labels the results.
"""
