"""Where the drivers of the real robot will stand: a P3-DX over ARCOS, a URG-04LX over SCIP. None is here yet."""
