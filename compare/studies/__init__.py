"""Studies of the program itself, and of what is said about ICs: many scenes, one page each.

May import all floors but the command line.
"""
