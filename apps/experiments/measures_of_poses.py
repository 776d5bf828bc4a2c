"""Poses as 3x4 lists of rows: read, turned, compared. No numpy: where frames are tracked, Python alone is there."""

import math


def read_poses(path):
    return [transform([float(word) for word in line.split()]) for line in path.read_text().splitlines() if line.strip()]


def transform(numbers):
    return [list(numbers[4 * row:4 * row + 4]) for row in range(3)]


def write_pose(path, pose):
    path.write_text("\n".join(" ".join("{:.12g}".format(value) for value in row) for row in pose) + "\n")


def product(a, b):
    """Of two 3x3 matrices."""
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def rotation_about(axis, angle):
    length = math.sqrt(sum(value * value for value in axis))
    x, y, z = (value / length for value in axis)
    c, s = math.cos(angle), math.sin(angle)
    return [[c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s],
            [y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s],
            [z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c)]]


def turned(pose, axis, angle):
    """About the object's origin, camera axes."""
    R = product(rotation_about(axis, angle), [row[:3] for row in pose])
    return [R[row] + [pose[row][3]] for row in range(3)]


def of_row(row):
    """The pose of a row of `track --poses`."""
    x, y, z, w = (float(row[name]) for name in ("qx", "qy", "qz", "qw"))
    R = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
         [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
         [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    return [R[i] + [float(row[name])] for i, name in enumerate(("tx", "ty", "tz"))]


def error(row, truth, pose=None):
    """Millimetres and degrees between a row's pose, or `pose`, and the truth."""
    pose = pose or of_row(row)
    millimetres = 1e3 * math.sqrt(sum((pose[i][3] - truth[i][3]) ** 2 for i in range(3)))
    trace = sum(pose[i][j] * truth[i][j] for i in range(3) for j in range(3))
    return millimetres, math.degrees(math.acos(max(-1.0, min(1.0, (trace - 1) / 2))))
