"""A run as the rerun viewer shows it, live or recorded; only broadcast.py and what it imports import rerun."""
