"""What closing loops is worth and what it costs: runs with loops and without, their scores and tables."""
