"""How good a trajectory is: the field's usual measures, as evo and the tools of the relations benchmark have them."""
