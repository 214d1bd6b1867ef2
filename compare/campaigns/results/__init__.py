"""Kinds of results that a campaign can keep of each scene, and the registry of them."""
