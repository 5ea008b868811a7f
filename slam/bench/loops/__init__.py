"""Benefit and cost of loop closing: runs with and without it, their scores and tables."""
