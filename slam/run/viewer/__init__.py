"""A run as the rerun viewer shows it: live, or recorded. Only feed.py's side of the package imports rerun."""
