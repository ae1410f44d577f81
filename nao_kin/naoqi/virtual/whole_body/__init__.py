"""Whole-body control: what of feet and balance is kept, and the tasks that keep it."""
