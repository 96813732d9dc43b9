"""The presets that come along, and what a preset may contain: tables, values, defaults, errors."""
