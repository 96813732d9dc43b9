"""What air takes from light on its way, and what it adds."""
