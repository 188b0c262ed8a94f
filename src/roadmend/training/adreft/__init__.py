"""Training of ADReFT: frames, labels, the supervised stage and reinforcement fine-tuning (ADReFT section 3.2)."""
