"""Pictures and films for people to look at."""
