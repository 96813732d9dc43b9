"""Ways to thin a world before it is rendered, which the experiment `rivals` compares."""
