"""How often estimates of contact results hold: random contacts against elements four times smaller."""
