"""The NCT 99M/2000M dialect: what its codes, words and variables do, registered once, and the decoder that executes programs."""
