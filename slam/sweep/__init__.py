"""Many runs: scenarios and logs, by mode, settings and seed, on this machine or on a cluster."""
