"""Sections of rails and wheels: as points, from files, from standards, prepared as contours."""
