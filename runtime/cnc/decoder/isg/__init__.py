"""The functions, statements and variables of the ISG dialect: what each of them does, registered once."""
