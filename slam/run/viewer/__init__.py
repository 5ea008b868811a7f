"""A run as the rerun viewer shows it, live or recorded. Only what comes after broadcast.py imports rerun."""
