"""Programs of others enter the benchmark: their pictures are scored, run, and listed."""
