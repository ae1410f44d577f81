"""Every export, loaded in the tool it is meant for: which tools, how each is asked, and the page of answers."""
