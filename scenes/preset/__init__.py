"""This package says what a preset may contain: tables, values, defaults and errors."""
