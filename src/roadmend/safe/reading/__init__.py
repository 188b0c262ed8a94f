"""The embedded reader: English crash summaries to the scenario language by rules, without a model or a network."""
