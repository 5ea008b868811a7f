"""Recorded logs made harder, one fault at a time, and how well the method stands them."""
