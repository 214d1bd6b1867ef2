"""Maps of C: C of scenes between those of a campaign, by interpolation, with its error on left-out nodes."""
