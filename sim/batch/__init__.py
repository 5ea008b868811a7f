"""Thousands of kinematic robots at once: the vector entry point of the learning environments."""
