"""Reports: a folder for each command that writes files, figures and a page from results.

Modules of this floor may import the floors below it: `scenes`, `results` and `pages`.
"""
