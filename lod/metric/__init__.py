"""Priority, range and bound of parts, and the limit distance that each metric gives them."""
