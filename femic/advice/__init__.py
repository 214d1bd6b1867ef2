"""What to expect of approximate ICs in a contact before C is solved: known random scenes, and bounds from them.

Imports bodies, approximations, contact and C; knows no scene files and no pages.
"""
