"""Figures of single sequences, from the table a frame that `holdfast evaluate --csv` writes."""

import math
import statistics


def number(row, name):
    return float(row[name]) if row[name] else math.nan


def error(row):
    """mm in all, mm across, mm in depth, degrees."""
    x, y, z = (number(row, "error_{}_mm".format(axis)) for axis in "xyz")
    return math.sqrt(x * x + y * y + z * z), math.hypot(x, y), abs(z), number(row, "error_deg")


def largest(rows):
    """The largest of each error over these frames."""
    return [max(column) for column in zip(*map(error, rows))] if rows else [0.0] * 4


def within(row, mm, degrees):
    distance, _, _, turn = error(row)
    return distance <= mm and turn <= degrees


def held(row):
    return row["status"] == "held"


def first_beyond(rows, mm, degrees):
    """The first row that is farther off, or None."""
    return next((row for row in rows if not within(row, mm, degrees)), None)


def before_hidden(rows, share):
    """Frames until the visible share first falls to `share`."""
    for i, row in enumerate(rows):
        if number(row, "visible") <= share:
            return rows[:i]
    return rows


def wrong(row):
    """Reported held while more than 20 mm or 5 degrees off."""
    return held(row) and not within(row, 20, 5)


def occluder_share(rows):
    """Share of the pixels used that show the occluder, over frames in which any was used on it or could have been."""
    used = [row for row in rows if row["mask_used"] and number(row, "visible") < 1]
    total = sum(int(row["mask_used"]) for row in used)
    return sum(int(row["mask_used_on_occluder"]) for row in used) / total if total else math.nan


def frames_until_held_again(rows, share):
    """Frames since the visible share last rose above `share`, after falling below it, until held within 20 mm and 5
    degrees; None: not held again. 0: held when it rose."""
    lowest = min(range(len(rows)), key=lambda i: number(rows[i], "visible"))
    if number(rows[lowest], "visible") >= share:
        return 0
    seen = next((i for i in range(lowest, len(rows)) if number(rows[i], "visible") >= share), None)
    if seen is None:
        return None
    again = next((i for i in range(seen, len(rows)) if held(rows[i]) and within(rows[i], 20, 5)), None)
    return None if again is None else again - seen


def text(value, digits=2):
    if value is None:
        return "never"
    if math.isnan(value):
        return "-"
    return "{:.{}f}".format(value, digits if abs(value) < 9.995 else 1 if abs(value) < 99.95 else 0)


def spread(values, digits=2):
    """min / median / max as text. None counts as infinitely large."""
    known = sorted(math.inf if value is None else value for value in values)
    if not known or any(math.isnan(value) for value in known):
        return "-"
    middle = statistics.median(known)
    return " / ".join("never" if math.isinf(value) else text(value, digits) for value in (known[0], middle, known[-1]))
