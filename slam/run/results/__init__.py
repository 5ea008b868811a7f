"""The folder of a run: written as the run goes, read back, and measured."""
