"""Terminal, tables, signals and shared options of the command line."""
