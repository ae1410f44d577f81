"""Poses of the whole NAO on one or both feet."""
