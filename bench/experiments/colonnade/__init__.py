"""The experiment `colonnade`."""
