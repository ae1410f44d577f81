"""Joint values of any robot by damped least squares inside the limits."""
