"""Saved maps, to be continued or localised in."""
