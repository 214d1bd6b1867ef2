"""The IC matrix of a scene: computed, checked, written strip by strip."""
