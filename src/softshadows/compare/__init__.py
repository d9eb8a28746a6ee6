"""Techniques beside the truth: measured, and written as a page and JSON.

comparison     pictures through techniques, and the folder that comes of it
measure        one shot through several techniques: frames, times, errors
interleaved    frames of several techniques, timed interleaved
choice         which techniques a shot and the words of a command line ask for
kept           measurements on disk, from which an interrupted comparison goes on
schedule       how far a long run has come
environment    the machine, the adapter and the versions behind the figures
pictures       arrays to PNG
plates         the pictures of a measurement
results        the JSON that benchmarks and the page are made from
schema         its shape, checked
console        what is shown on a terminal
page/          the HTML page: template, tables, plot, data, and the script that draws them
"""
