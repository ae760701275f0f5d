# A PC: built by the Makefile itself.
