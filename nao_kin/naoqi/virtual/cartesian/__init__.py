"""Cartesian control: paths of effectors over time, and the joint values that follow them."""
