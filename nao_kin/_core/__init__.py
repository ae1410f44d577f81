"""Common helpers: checks of arguments, numbers, messages, atomic writing of files, signals."""

__version__ = "0.4.0.dev0"
