"""What each command makes of results, a folder each: files, figures and a page.

Imports the floors below: `scenes`, `results`, `pages`.
"""
