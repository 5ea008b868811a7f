"""The commands of the devices."""
