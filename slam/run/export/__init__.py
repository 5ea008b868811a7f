"""A run in the formats of other tools: formats.py has the table of them."""
