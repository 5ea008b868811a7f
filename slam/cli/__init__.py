"""One file a command (or two that belong together): its options, its help, its examples."""
