"""Saved maps, for continued mapping or localisation."""
