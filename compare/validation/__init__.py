"""Studies of the program itself and of statements about ICs: many scenes, one page each."""
