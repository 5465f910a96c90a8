"""House rules that no linter holds. Each is a function of a checkout that returns its breaches; `tests/test_house.py` asserts that there are none."""
