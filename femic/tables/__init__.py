"""Tables of contacts: creep forces of a pair at many positions, loads and creepages, for use without femic.

`creep_table.py` and `creep_table.h` read them and need nothing of femic. Knows contacts, not scenes.
"""
