"""How work is done and kept: processes, threads, the store of finished models, their provenance."""
