"""What to expect of approximate ICs in a contact before C is solved: bounds from known random scenes.

Imports bodies, approximations, contact and C; knows no scene files and no pages.
"""
