"""The real robot: a Pioneer P3-DX over ARCOS and a Hokuyo URG-04LX over SCIP, behind the same ``Robot`` protocol."""
