"""Campaign files: their keys, and a campaign's axes and points in the order of computation."""
