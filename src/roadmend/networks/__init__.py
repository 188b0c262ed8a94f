"""Networks: encoders and heads, their compiled twins, and model files."""
