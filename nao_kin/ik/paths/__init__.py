"""Joint trajectories along paths of targets."""
