"""Recorded logs made harder in known ways, and how the method stands them."""
