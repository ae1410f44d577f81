"""Load every export in its tool: the tools, the probes that measure them, and the page of results."""
