"""What a preset may say: tables, values, defaults and errors."""
