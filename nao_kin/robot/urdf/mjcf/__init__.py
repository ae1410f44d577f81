"""MJCF, MuJoCo's own format: parsed and compiled by MuJoCo, and turned into a tree like that of a URDF."""
