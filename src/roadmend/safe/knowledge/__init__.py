"""The knowledge base: how to analyse a crash on each type of road, each with worked examples. All cases are made up."""
