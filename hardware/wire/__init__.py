"""The traffic on the ports: recorded in a file, listed in words, and played to the drivers like a device."""
