"""What a learning environment is made of: actions, views, rewards, ends and the picture from above."""
