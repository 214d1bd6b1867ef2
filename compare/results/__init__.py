"""Computing a scene and storing what was found: ICs, IC matrices, errors, what a model will take.

Imports `scenes` and nothing else of `compare`.
"""
