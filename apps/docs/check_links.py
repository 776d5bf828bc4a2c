#!/usr/bin/env python3
"""check_links.py SITE: every link and picture of a built site leads to a file of it, and to a place that is there."""

import html.parser
import pathlib
import sys
import urllib.parse


class Page(html.parser.HTMLParser):
    def __init__(self, path):
        super().__init__(convert_charrefs=True)
        self.links, self.places = set(), {"", "top"}
        self.feed(path.read_text(encoding="utf-8", errors="replace"))

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("id", "name") and value:
                self.places.add(value)
            elif name in ("href", "src") and value:
                self.links.add(value)


def broken_links(site):
    pages = {path: Page(path) for path in site.rglob("*.html")}
    for path, page in sorted(pages.items()):
        for link in sorted(page.links):
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            if target.is_dir():
                target /= "index.html"
            place = urllib.parse.unquote(parts.fragment)
            if not target.is_file() or target in pages and place not in pages[target].places:
                yield "{}: {}".format(path.relative_to(site), link)


def main():
    site = pathlib.Path(sys.argv[1]).resolve()
    broken = list(broken_links(site))
    print("links: {} pages, {} broken".format(len(list(site.rglob("*.html"))), len(broken)))
    sys.exit("\n".join(broken) or 0)


if __name__ == "__main__":
    main()
