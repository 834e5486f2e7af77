"""The text of the NCT 99M/2000M dialect: programs, blocks, expressions → compiled blocks."""
