"""What to expect of approximate ICs in a contact before C is solved: bounds from known random scenes.

Imports bodies, approximations and contact; knows no scene files and no pages. The random scenes are solved by
tools/advice_study.py.
"""
