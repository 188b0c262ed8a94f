"""Networks: in torch for training, compiled for driving, and as files between the two."""
