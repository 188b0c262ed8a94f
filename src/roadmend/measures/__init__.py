"""What an episode is worth: measures, intervals, paired tests, and evaluation over many episodes."""
