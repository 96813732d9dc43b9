"""The experiment `spectrum`."""
