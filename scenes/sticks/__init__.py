"""Areas, contrast and views of sticks: what a part can look like."""
