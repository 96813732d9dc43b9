"""Programs of others that measure beside us, each in an environment of its own."""
