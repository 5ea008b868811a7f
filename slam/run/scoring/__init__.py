"""Scores of a trajectory: the field's usual measures, as evo and the tools of the relations benchmark have them."""
