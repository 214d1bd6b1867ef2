"""Drawing and layout that all reports share: figures, 3D views, styles of variants, templates of pages.

Imports `scenes` and `results`.
"""
