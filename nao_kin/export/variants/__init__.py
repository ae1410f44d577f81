"""Variants of a robot's tree: pure functions from a tree to another one and to one line for each change made.

They are applied in this order: `couple`, `merge_balls`, `keep_frames`, `make_physical`, `name_frames`, `align_axes`.
"""
