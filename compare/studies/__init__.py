"""Studies, which need many solutions: frontiers, advice, crossings."""
