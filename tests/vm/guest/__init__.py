"""What runs inside the virtual machine. It acts and observes; the tests outside judge what it has seen."""
