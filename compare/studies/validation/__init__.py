"""`femic validate`: what is said about these ICs, and about this program, checked with computed verdicts."""
