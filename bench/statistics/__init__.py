"""Estimates, intervals and fits; no files."""
