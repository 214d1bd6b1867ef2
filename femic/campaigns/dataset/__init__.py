"""The dataset of all scenes of a campaign, with a checksum per scene, and outcomes of scenes in the store."""
