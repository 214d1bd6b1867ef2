"""The page of a campaign: what the swept keys do to errors, contacts, fits and advice."""
