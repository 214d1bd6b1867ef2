"""Results of scenes: each question is solved, and its answer labelled as a dataset."""
