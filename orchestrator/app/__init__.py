"""The program: command line, the chain of stages, runs of many cases and what is said of them."""
