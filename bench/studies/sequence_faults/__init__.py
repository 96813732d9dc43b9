"""Sequences that are killed, damaged, interrupted and starved of disk."""
