"""Harder variants of recorded logs, and the method's errors on them."""
