"""Techniques beside the truth: measured (measure.py), written as a page and JSON (compare.py), in suites (suites/).

environment    the machine, the adapter and the versions behind the figures
kept           measurements on disk, from which an interrupted comparison goes on
schedule       how far a long run has come
measure        one shot through several techniques: frames, times, errors
turns          frames of several techniques timed in turns
tree_times     trees for rays: how long they take to build, to fit and to walk
pictures       arrays to PNG
results        the JSON that benchmarks and the page are made from
schema         its shape, checked
changes        what got worse from one JSON to another
benchmarks     the benchmark page, with the charts of charts.py
page/          the HTML page: template, tables, plot, data, and the script that draws them
demo           `make demo`
"""
