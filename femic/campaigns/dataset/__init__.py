"""The dataset of all scenes of a campaign, with checksums, and the outcomes of scenes in the store."""
