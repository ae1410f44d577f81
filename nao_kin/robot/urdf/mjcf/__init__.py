"""MJCF, MuJoCo's own format: parsed and compiled by MuJoCo, and turned into the tree that a URDF becomes."""
