"""The page of a campaign: errors, contacts, fits and advice over the swept keys."""
