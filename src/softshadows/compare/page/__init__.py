"""The compare page: one HTML file that holds its pictures and its data, opens anywhere and needs no network.

page        the file from its template
tables      the figures
plot        error against time, as SVG
notes       the techniques in words, from their manual pages
payload     pictures and visibility images for the explorer, packed
index.html  the template; page.css and page.js go into it
"""

from softshadows.compare.page.page import page

__all__ = ["page"]
