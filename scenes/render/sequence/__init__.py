"""This package renders sequences of frames, on this machine or on a cluster."""
