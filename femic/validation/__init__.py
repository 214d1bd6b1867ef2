"""Studies of the program itself and of statements about ICs: many scenes, one page each.

Modules of this floor may import all floors except the command line.
"""
