"""The built-in machine: a three-axis mill with clamp, coolant and tool changer, its PLC program and a program to mill."""
