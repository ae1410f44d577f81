"""What every room may use: arrays and vectors checked at the door, numbers, files written whole, signals."""

__version__ = "0.3.0"
