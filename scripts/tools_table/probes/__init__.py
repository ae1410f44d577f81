"""One module per tool, each with `load(path)`: they run in the environment of the tool, which has no nao_kin."""
