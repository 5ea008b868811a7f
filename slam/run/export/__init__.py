"""Export of a run in the formats of other tools, listed in formats.py."""
