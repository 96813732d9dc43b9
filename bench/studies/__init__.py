"""Measurements beside the experiments."""
