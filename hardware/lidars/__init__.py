"""The drivers of lidars: each reads its sensor on a thread, and puts whole scans into a queue."""
