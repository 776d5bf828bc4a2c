"""What recovery.py simulates: models, a plate that covers them, and how both move, made from a seed."""

import numpy as np

SIZE = (640, 480)
FOCAL = 650.0
BEFORE, GOING, HIDDEN, COMING, AFTER = 20, 10, 30, 10, 20
FRAMES = BEFORE + GOING + HIDDEN + COMING + AFTER
MODELS = ("box", "can", "vase")
SHAPES = ("box", "part")  # followed by their shape alone: a printed one and one of one colour
KINDS = ("covered", "left")


def print_of(rng, width, height, shapes, contrast=1.0):
    """A picture of coloured blocks and discs, as print on packages is."""
    ground = rng.uniform(0.25, 0.9, 3)
    picture = np.ones((height, width, 3)) * ground
    y, x = np.mgrid[0:height, 0:width]
    for _ in range(shapes):
        cx, cy = rng.uniform(0, width), rng.uniform(0, height)
        a, b = rng.uniform(0.01, 0.09, 2) * width
        # The seam of a label that goes round is no edge.
        dx, dy = np.abs((x - cx + width / 2) % width - width / 2), np.abs(y - cy)
        inside = (dx < a) & (dy < b) if rng.random() < 0.6 else (dx / a) ** 2 + (dy / b) ** 2 < 1
        picture[inside] = ground + contrast * (rng.uniform(0.05, 0.95, 3) - ground)
    return picture


def model(positions, coordinates, quads, picture):
    """Arrays of a mesh: vertices, faces, uv, image; quads index positions, which have a coordinate each."""
    faces = [[quad[i] for i in corner] for quad in quads for corner in ((0, 1, 2), (0, 2, 3))]
    return (np.array(positions, float), np.array(faces), np.array(coordinates),
            (255 * np.clip(picture, 0, 1)).astype(np.uint8))


def turned_profile(radii, heights, around=48):
    """A surface of revolution about y with a label all around; closed at its ends where radii are 0."""
    positions, coordinates, quads = [], [], []
    along = np.concatenate([[0], np.cumsum(np.hypot(np.diff(radii), np.diff(heights)))])
    for radius, height, way in zip(radii, heights, along / along[-1]):
        for i in range(around + 1):
            angle = 2 * np.pi * i / around
            positions.append((radius * np.sin(angle), height, radius * np.cos(angle)))
            coordinates.append((i / around, way))
    for ring in range(len(radii) - 1):
        for i in range(around):
            a = ring * (around + 1) + i
            quads.append((a, a + 1, a + around + 2, a + around + 1))
    return np.array(positions), coordinates, quads


def can(rng, contrast):
    half, radius = 0.5 * rng.uniform(0.1, 0.14), rng.uniform(0.03, 0.045)
    radii = np.array([0, radius, radius, 0])
    positions, coordinates, quads = turned_profile(radii, np.array([-half, -half, half, half]))
    return model(positions, coordinates, quads, print_of(rng, 1024, 768, 220, contrast))


def vase(rng, contrast):
    t = np.linspace(0, 1, 25)
    phase, waist = rng.uniform(0, 2 * np.pi), rng.uniform(0.25, 0.45)
    radii = rng.uniform(0.04, 0.06) * (1 + waist * np.sin(phase + 2.2 * np.pi * t))
    heights = rng.uniform(0.14, 0.2) * (t - 0.5)
    radii = np.concatenate([[0], radii, [0]])
    heights = np.concatenate([heights[:1], heights, heights[-1:]])
    positions, coordinates, quads = turned_profile(radii, heights)
    return model(positions, coordinates, quads, print_of(rng, 1024, 1024, 260, contrast))


def part(rng):
    """An L of one colour, of three different sides, as long as its legs are wide apart."""
    a, b, c = rng.uniform(0.14, 0.2), rng.uniform(0.08, 0.12), rng.uniform(0.05, 0.09)
    u, v = rng.uniform(0.3, 0.45) * a, rng.uniform(0.35, 0.5) * b
    outline = np.array([(0, 0), (a, 0), (a, v), (u, v), (u, b), (0, b)]) - 0.5 * np.array([a, b])
    positions = [(x, y, z) for z in (-0.5 * c, 0.5 * c) for x, y in outline]
    walls = [[i, (i + 1) % 6, 6 + (i + 1) % 6, 6 + i] for i in range(6)]
    ends = [[0, 1, 2, 3], [0, 3, 4, 5]]
    quads = walls + [quad[::-1] for quad in ends] + [[6 + i for i in quad] for quad in ends]
    return model(positions, [(0.5, 0.5)] * 12, quads, np.ones((2, 2, 3)) * rng.uniform(0.25, 0.8, 3))


def plate(rng, side):
    """Square, seen from both sides."""
    corners = [(0.5 * side * x, 0.5 * side * y, 0) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return model(corners, [(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2, 3), (3, 2, 1, 0)], print_of(rng, 512, 512, 60))


def rotation(axis, angle):
    x, y, z = axis / np.linalg.norm(axis)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def eased(count):
    """From above 0 to 1 in `count` steps, slow at both ends."""
    t = np.arange(1, count + 1) / count
    return t * t * (3 - 2 * t)


def place(rng, reach, depth, inset):
    """A point at this depth that shows an object of `reach` pixels well inside the picture."""
    margin = np.minimum(reach * inset, 0.45 * np.array(SIZE))
    pixel = rng.uniform(margin, np.array(SIZE) - margin)
    return np.array([*((pixel - (np.array(SIZE) - 1) / 2) / FOCAL), 1.0]) * depth


def beyond(rng, inside, reach):
    """From a point inside out of the picture over one of its sides, and straight enough to cross none other."""
    side, depth = rng.integers(4), inside[2]
    pixel = inside[:2] / depth * FOCAL + (np.array(SIZE) - 1) / 2
    out = pixel.copy()
    axis, sign = side // 2, side % 2
    out[axis] = SIZE[axis] + 1.2 * reach if sign else -1.2 * reach
    return np.array([*((out - (np.array(SIZE) - 1) / 2) / FOCAL), 1.0]) * depth


def trial(rng, kind, positions):
    """Poses (object to camera) and poses of the plate, or None where nothing covers; and the turn while hidden, degrees."""
    middle = 0.5 * (positions.min(axis=0) + positions.max(axis=0))
    radius = np.linalg.norm(positions - middle, axis=1).max()
    depth = FOCAL * 2 * radius / rng.uniform(80, 230)
    reach = FOCAL * radius / depth
    upright = np.diag([1.0, -1.0, -1.0])
    R0 = (rotation(np.array([0, 0, 1.0]), np.radians(rng.uniform(-25, 25)))
          @ rotation(np.array([1.0, 0, 0]), np.radians(rng.uniform(5, 45)))
          @ rotation(np.array([0, 1.0, 0]), np.radians(rng.uniform(-180, 180))) @ upright)
    turn = np.radians(rng.uniform(5, 40))
    hidden_axis = rng.normal(size=3)
    again = np.clip(depth * rng.uniform(0.8, 1.25), 0.5 * depth, None)
    start, lost = place(rng, reach, depth, 1.0), place(rng, reach, depth, 1.0)
    lost = start + 0.25 * (lost - start)
    found = place(rng, reach * depth / again, again, 1.0)
    drift = 0.15 * (place(rng, reach, again, 1.0) - found)
    axis, small = rng.normal(size=3), np.radians(rng.uniform(3, 12))

    way, turned = [start], [np.eye(3)]
    for s in eased(BEFORE - 1):
        way.append(start + s * (lost - start))
        turned.append(rotation(axis, s * small))
    before = turned[-1]
    steps = GOING + HIDDEN + COMING
    if kind == "covered":
        where = np.concatenate([np.zeros(GOING), eased(HIDDEN), np.ones(COMING)])
        way += [lost + s * (found - lost) for s in where]
        turned += [rotation(hidden_axis, s * turn) @ before for s in where]
    else:
        out, back = beyond(rng, lost, reach), beyond(rng, found, reach * depth / again)
        go = (np.arange(1, GOING + 1) / GOING) ** 2
        way += [lost + s * (out - lost) for s in go]
        way += [out] * (HIDDEN // 2) + [back] * (HIDDEN - HIDDEN // 2)  # round the picture, not through it
        way += [found + s * (back - found) for s in (1 - np.arange(1, COMING + 1) / COMING) ** 2]
        where = np.concatenate([np.zeros(GOING), eased(HIDDEN), np.ones(COMING)])
        turned += [rotation(hidden_axis, s * turn) @ before for s in where]
    last = turned[-1]
    for s in eased(AFTER):
        way.append(way[BEFORE + steps - 1] + s * drift)
        turned.append(rotation(axis, s * small) @ last)

    poses = []
    for point, R in zip(way, turned):
        R = R @ R0
        poses.append(np.hstack([R, (point - R @ middle)[:, None]]))
    if kind == "left":
        return np.array(poses), None, np.degrees(turn)

    # The plate stays between camera and object, at six tenths of the way, and slides off sideways.
    plates, nearer = [], 0.6
    aside = [rotation(np.array([0, 0, 1.0]), angle) @ np.array([1.0, 0, 0]) for angle in rng.uniform(-np.pi, np.pi, 2)]
    side = 2.6 * radius * nearer
    away = np.concatenate([np.full(BEFORE, 6.0), 1.25 * (1 - eased(GOING)), np.zeros(HIDDEN), 1.25 * eased(COMING),
                           np.full(AFTER, 6.0)])
    away[BEFORE + steps:] = 1.25 + 0.15 * np.arange(AFTER)
    away[:BEFORE] = 1.25 + 0.15 * np.arange(BEFORE)[::-1]
    for i, point in enumerate(way):
        centre = nearer * point + side * away[i] * aside[0 if i < BEFORE + GOING + HIDDEN // 2 else 1]
        plates.append(np.hstack([np.eye(3), centre[:, None]]))
    return np.array(poses), (np.array(plates), side), np.degrees(turn)


def share_inside(poses, positions):
    """Of the model's points, the share whose projection is inside the picture: of each pose."""
    shares = []
    for pose in poses:
        p = positions @ pose[:, :3].T + pose[:, 3]
        pixels = p[:, :2] / p[:, 2:] * FOCAL + (np.array(SIZE) - 1) / 2
        shares.append(np.mean(np.all((pixels >= 0) & (pixels <= np.array(SIZE) - 1), axis=1)))
    return np.array(shares)
