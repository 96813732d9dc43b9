"""This package measures sticks: areas, contrast and views, and so what a part can look like."""
