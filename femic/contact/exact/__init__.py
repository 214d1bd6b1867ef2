"""Contact solutions to compare numerical ones with: Hertz, the pin in a hole, friction and rolling."""
