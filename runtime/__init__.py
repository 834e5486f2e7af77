"""Tandem: a soft PLC and a CNC in one runtime for Linux industrial PCs."""
