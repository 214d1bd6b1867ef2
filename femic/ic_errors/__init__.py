"""Errors of ICs against C: their measure, and deviations of whole matrices. It imports `femic.reference`."""
