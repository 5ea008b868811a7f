"""The learning environment: its actions, views, rewards, ends and the picture from above."""
