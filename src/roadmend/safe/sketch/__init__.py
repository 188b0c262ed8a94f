"""The sketch of a crash: its words, its vehicles and how they stand, its north, the legs of its road."""
