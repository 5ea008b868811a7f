"""What a run shows and leaves behind: its folder, its metrics and its pictures."""
