"""Pruned and whole frames beside one another."""
