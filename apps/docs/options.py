#!/usr/bin/env python3
"""Writes docs/reference/options.md: what `holdfast COMMAND --help` prints, a section a command.

  options.py PROGRAM [--check]     --check: fails where the page is not what it would be
"""

import pathlib
import re
import subprocess
import sys
import textwrap

PAGE = pathlib.Path(__file__).parents[2] / "docs" / "reference" / "options.md"
COMMANDS = ("track", "init", "show", "bake", "simulate", "evaluate", "devices")
HEAD = """# Options

`make options` writes this page from `holdfast COMMAND --help`. Options may also stand in a file
([`--config`](files.md#configuration)). What a command ends with: [exit codes](exit_codes.md).
"""


def groups_of(program, command):
    """The help text in groups of options, without its last paragraph, the exit codes, which have a page of their own."""
    text = subprocess.run([program, command, "--help"], capture_output=True, text=True, check=True).stdout
    text = "\n".join(line.rstrip() for line in text.split("\nExit codes:")[0].splitlines())
    return [group.strip("\n") for group in text.split("\n\n") if group.strip()]


def shortened(group, command, first):
    """A group without the options that an earlier command has too, which are only named; `first`: who has them."""
    title, *entries = re.split(r"\n(?=  -)", group)
    known = {}
    for entry in list(entries):
        if first.setdefault(entry, command) != command:
            known.setdefault(first[entry], []).append(re.search(r"--[\w-]+", entry).group())
            entries.remove(entry)
    if not known:
        return group
    if not entries and len(known) == 1:
        return "{} as of {}".format(title, *known)
    said = "; ".join("{} as of {}".format(", ".join(names), whose) for whose, names in known.items())
    return "\n".join([title, *entries, *textwrap.wrap(said, 100, initial_indent="  ", subsequent_indent="  ",
                                                       break_on_hyphens=False)])


def page(program):
    """Options that several commands share are listed where they come first."""
    sections, first = [HEAD], {}
    for command in COMMANDS:
        groups = [shortened(group, command, first) for group in groups_of(program, command)]
        sections.append("## {0}\n\n```text\n{1}\n```\n".format(command, "\n\n".join(groups)))
    return "\n".join(sections)


def main():
    text = page(sys.argv[1])
    if "--check" not in sys.argv:
        PAGE.write_text(text)
    elif not PAGE.is_file() or PAGE.read_text() != text:
        sys.exit("{} is not what --help says: run `make options`".format(PAGE))


if __name__ == "__main__":
    main()
