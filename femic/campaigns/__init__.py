"""Campaigns: one scene over ranges of its keys, computed on a cluster.

Folders, lowest first; each imports those above it in this list only (an import contract checks it):

- `files`: campaign files, their axes and points;
- `dataset`: the dataset of all scenes, with checksums, and what the store has of single scenes;
- `maps`: C, and fits of B-hat-prime, between the scenes of a campaign;
- `results`: the kinds of results of a scene, one registration each;
- `running`: tasks, clusters, the run; `report`: the page.
"""
