"""Scores of a trajectory: the usual measures, as in evo and the relations benchmark."""
