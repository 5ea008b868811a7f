"""Bytes that pass over the ports: kept in a file, listed in words, and played to the drivers as a device."""
