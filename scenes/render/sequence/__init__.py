"""Sequences of frames, on this machine or a cluster."""
