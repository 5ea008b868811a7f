"""Maps that are saved, and continued or localised in."""
