"""Processes, threads, the store of finished models, and the provenance of stored models."""
