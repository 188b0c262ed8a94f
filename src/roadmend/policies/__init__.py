"""The driving policies under repair."""
