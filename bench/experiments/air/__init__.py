"""The experiment `air`."""
