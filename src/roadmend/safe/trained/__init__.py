"""The trained reader: a small network that has read many told crashes, as one more source of claims."""
