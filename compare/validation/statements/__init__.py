"""`femic validate` judges statements about these ICs and about this program by computed numbers."""
