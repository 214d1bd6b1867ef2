"""Campaigns: one scene over ranges of its keys, computed on a cluster."""
