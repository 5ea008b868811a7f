"""Gain and cost of closing loops: runs with loops and without, their scores and tables."""
