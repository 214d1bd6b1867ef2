"""Coverage of estimates of contact results: random contacts against elements four times smaller."""
