"""Contact solutions to compare numerical ones with: Hertz, friction and rolling."""
