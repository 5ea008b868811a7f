"""One file per command, or per group of related commands: options, help, examples."""
