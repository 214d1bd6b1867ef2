"""Parallel work, files of results, the store of finished models, and digests of the code behind them."""
