"""One run: set up, driven, recorded, shown, reported, exported and scored."""
