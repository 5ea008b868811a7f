"""Everything around the method: scenarios, the loop, recording, replay, pictures and the command line."""
