"""Techniques beside the truth: measured (measure.py), written as a page and JSON (compare.py), in suites (suites/).

environment    the machine, the adapter and the versions behind the figures
measure        one shot through several techniques: frames, times, errors
pictures       arrays to PNG
results        the JSON that benchmarks and the page are made from
page           the HTML page
demo           `make demo`
"""
