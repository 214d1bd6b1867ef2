"""Computes scenes and stores the results: ICs, IC matrices, errors, and what models take.

Imports `scenes` and nothing else of `compare`.
"""
