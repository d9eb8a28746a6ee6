"""Suites of measurements for developers, what changed between two runs of them, and the page made from them."""
