"""What grass costs a frame, how its cost grows with density, and whether it ends with an edge."""
