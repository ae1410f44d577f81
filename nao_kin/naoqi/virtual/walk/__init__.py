"""The kinematic walk: what a step may be, where the feet go, and the joint values that take them there."""
