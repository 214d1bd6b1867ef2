"""Maps: C, and fits of B-hat-prime, of scenes between those of a campaign; errors on left-out nodes."""
