"""This package raises dust: where feet strike dry ground and where wind blows over it."""
