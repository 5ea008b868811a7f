"""Graphs of runs whose loops were closed, as files."""
