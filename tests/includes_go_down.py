"""includes_go_down.py LIB: files of a room of lib/ include only their own room and rooms below it.

Public headers and those of kernels/ are free.
"""

import re
import sys
from pathlib import Path

ROOMS = ["base", "device", "render", "image", "solve", "texture", "contour", "edges", "imaging", "motion", "judge", "recovery",
         "tracker"]  # from bottom to top
ABOVE_BASE_ONLY = ("io", "detection")  # libraries of their own


def may_include(room, included):
    if room == included:
        return True
    if room in ABOVE_BASE_ONLY:
        return included == "base"
    return included not in ABOVE_BASE_ONLY and ROOMS.index(included) < ROOMS.index(room)


def includes_between_rooms(lib):
    """(file, included file, allowed) of every include directive whose target is a file of a room."""
    for path in sorted(lib.rglob("*")):
        if path.suffix not in (".cpp", ".hpp"):
            continue
        name = path.relative_to(lib).as_posix()
        room = name.split("/")[0]
        for included in re.findall(r'^\s*#\s*include\s*["<]([^">]+)[">]', path.read_text(), re.MULTILINE):
            # A quoted name may also be one beside the includer.
            target = next((t for t in (lib / included, path.parent / included) if t.is_file()), None)
            if target is not None:
                target = target.resolve().relative_to(lib).as_posix()
                yield name, target, may_include(room, target.split("/")[0])


def main():
    lib = Path(sys.argv[1]).resolve()
    rooms = {folder.name for folder in lib.iterdir() if folder.is_dir()}
    unknown = rooms - {*ROOMS, *ABOVE_BASE_ONLY}
    if unknown:
        sys.exit(f"Rooms of lib/ without a place in the order of {sys.argv[0]}: {', '.join(sorted(unknown))}")
    found = list(includes_between_rooms(lib))
    upwards = {(name, target) for name, target, allowed in found if not allowed}
    for name, target in sorted(upwards):
        print(f"lib/{name} includes {target}, which is not below it")
    if upwards:
        sys.exit(1)
    if len(found) < 50:
        sys.exit(f"only {len(found)} includes between files of {lib}: there should be more")
    print(f"{len(found)} includes between files of lib/, all downwards")


if __name__ == "__main__":
    main()
