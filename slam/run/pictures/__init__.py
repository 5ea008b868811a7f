"""Pictures of maps, errors, scans and worlds, in one style."""
