"""What passes over the ports: kept byte by byte in a file, listed in words, and played to the drivers as a device."""
