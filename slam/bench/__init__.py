"""Benchmarks against the paper, the truth and other methods: one report per command of ``hopslam bench``."""
