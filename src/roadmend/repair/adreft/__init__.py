"""ADReFT at run time: tokens of a scene, and a model that judges them (ADReFT section 3.1)."""
