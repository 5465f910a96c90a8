"""How many small mistakes in the code do the tests notice? `python -m experiments.mutants` tries them one by one."""
