"""Ways to thin a world before it is rendered, and programs of others that render or judge it."""
