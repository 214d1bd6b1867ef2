"""A wheelset that rolls: both wheels on one axle, in contact with friction, and the creep forces on them."""
