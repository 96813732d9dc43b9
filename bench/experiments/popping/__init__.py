"""The experiment `popping`."""
