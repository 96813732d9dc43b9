"""The experiment `pixels`."""
