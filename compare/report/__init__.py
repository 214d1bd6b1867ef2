"""The page system of all reports: pages, tables and charts as data, 3D views, looks of ICs.

It knows no question: it imports no other folder of `compare`.
"""
