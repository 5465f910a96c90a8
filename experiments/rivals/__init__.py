"""Rivals of the diagnosis on the same labelled cases: sparse regression, lasso, forward selection by BIC, and a list of friction models.

All of them start from the same fit of the rig as it is, and all say how sure they are by one measure: the share of the squared error on
the held-out runs that their names remove. So they can be compared with the library at the same coverage.
"""
