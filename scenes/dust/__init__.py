"""Dust that feet and wind raise."""
