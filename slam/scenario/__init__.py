"""A scenario: the YAML file that sets up an experiment, and its schema."""
