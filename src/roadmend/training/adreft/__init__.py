"""Training of ADReFT: frames and labels, the supervised stage, practice on trials or futures, and fine-tuning (ADReFT section 3.2)."""
