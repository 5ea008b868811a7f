"""Generators: worlds made from a seed and a few parameters, each with a route that a robot can drive."""
