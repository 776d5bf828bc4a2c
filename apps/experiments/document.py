"""Fills the generated parts of a Markdown file: what stands between <!-- begin NAME --> and <!-- end NAME -->."""

import re
import sys


def fill(path, parts):
    text = path.read_text(encoding="utf-8")
    for name, part in parts.items():
        pattern = re.compile(r"(<!-- begin {0} -->\n).*?(<!-- end {0} -->)".format(re.escape(name)), re.DOTALL)
        if not pattern.search(text):
            sys.exit("experiments: {} has no place for '{}'".format(path, name))
        text = pattern.sub(lambda found: found.group(1) + part.rstrip("\n") + "\n" + found.group(2), text)
    path.write_text(text, encoding="utf-8")


def table(heading, rows):
    """Rows of cells as Markdown."""
    lines = ["| " + " | ".join(heading) + " |", "|" + "---|" * len(heading)]
    lines += ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"
