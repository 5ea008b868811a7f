"""Benchmarks against the paper, the truth and other methods: one report a command of ``hopslam bench``."""
