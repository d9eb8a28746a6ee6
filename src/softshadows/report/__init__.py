"""Techniques beside the truth: measured (measure.py), written as a page and JSON (compare.py), in suites (suites/).

environment    the machine, the adapter and the versions behind the figures
kept           measurements on disk, from which an interrupted comparison goes on
schedule       how far a long run has come
measure        one shot through several techniques: frames, times, errors
pictures       arrays to PNG
results        the JSON that benchmarks and the page are made from
page/          the HTML page: template, tables, plot, data, and the script that draws them
demo           `make demo`
"""
