"""Ways that objects and fingers take: a pose a frame."""

import math

import numpy


def read_poses(path):
    return numpy.loadtxt(path).reshape(-1, 3, 4)


def write_poses(path, poses):
    numpy.savetxt(path, numpy.asarray(poses).reshape(-1, 12), fmt="%.9f")


def hull(points):
    """Convex hull of points in the plane, anticlockwise."""
    points = sorted(map(tuple, points))

    def half(points):
        chain = []
        for p in points:
            while len(chain) > 1 and ((chain[-1][0] - chain[-2][0]) * (p[1] - chain[-2][1])
                                      - (chain[-1][1] - chain[-2][1]) * (p[0] - chain[-2][0])) <= 0:
                chain.pop()
            chain.append(p)
        return chain[:-1]

    return half(points) + half(points[::-1])


def outermost(points):
    """Those that are farthest out in one of many directions: all that outlines need."""
    directions = numpy.random.default_rng(1).normal(size=(1000, 3))
    return points[numpy.unique((points @ directions.T).argmax(0))]


def area(polygon):
    return 0.5 * abs(sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(polygon, polygon[1:] + polygon[:1])))


def clipped(polygon, axis, limit, sign):
    """The part of a convex polygon with sign * coordinate <= sign * limit."""
    out = []
    for a, b in zip(polygon, polygon[1:] + polygon[:1]):
        inside_a, inside_b = sign * a[axis] <= sign * limit, sign * b[axis] <= sign * limit
        if inside_a:
            out.append(a)
        if inside_a != inside_b:
            t = (limit - a[axis]) / (b[axis] - a[axis])
            out.append((a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])))
    return out


def share_inside(points, pose, camera):
    """Of the convex outline of these points (object frame) in a picture: camera (width, height, f, cx, cy)."""
    width, height, f, cx, cy = camera
    p = points @ pose[:, :3].T + pose[:, 3]
    outline = hull(numpy.stack([f * p[:, 0] / p[:, 2] + cx, f * p[:, 1] / p[:, 2] + cy], 1))
    seen = outline
    for axis, limit, sign in ((0, -0.5, -1), (0, width - 0.5, 1), (1, -0.5, -1), (1, height - 0.5, 1)):
        seen = clipped(seen, axis, limit, sign)
    return area(seen) / area(outline)


def upright(yaw, pitch, roll):
    """Object with y up, front towards the camera, turned about y, then x, then z."""
    cy, sy, cp, sp, cr, sr = (g(a) for a in (yaw, pitch, roll) for g in (math.cos, math.sin))
    about_y = numpy.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_x = numpy.array([[1, 0, 0], [0, cp, -sp], [0, sp, cp]])
    about_z = numpy.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])
    return about_z @ about_x @ about_y @ numpy.diag([1.0, -1.0, -1.0])


def leaving(points, camera, distance, inside, frames):
    """From the middle of the picture to each side in turn, until only this share of the outline is inside, and back;
    turning a little all the while."""
    width, height, f, cx, cy = camera
    poses = []
    sides = ((-1, 0), (1, 0), (0, -1), (0, 1))
    a_side = frames // len(sides)
    for k in range(frames):
        side = sides[min(k // a_side, 3)]
        t = (k % a_side) / a_side
        rotation = upright(0.45 + 0.25 * math.sin(0.06 * k), 0.4 + 0.2 * math.sin(0.047 * k), 0.15 * math.sin(0.05 * k))

        def at(way):
            centre = numpy.array([way * side[0] * width / f, way * side[1] * height / f, 1]) * distance
            return numpy.concatenate([rotation, centre[:, None]], 1)

        low, high = 0.0, 1.0  # share of the picture's width or height
        for _ in range(40):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if share_inside(points, at(middle), camera) > inside else (low, middle)
        # Slow at the ends; a stay outside.
        way = 0.5 - 0.5 * math.cos(2 * math.pi * t)
        poses.append(at(low * min(1.0, 1.15 * way)))
    return poses


def turning(distance, turn, frames):
    """Turning about y by this many degrees, from above to below, and back; moving a little."""
    poses = []
    for k in range(frames):
        way = 0.5 - 0.5 * math.cos(2 * math.pi * k / (frames - 1))
        rotation = upright(0.45 + math.radians(turn) * way, 0.4 * math.cos(math.pi * way), 0.1 * math.sin(0.04 * k))
        centre = [0.05 * math.sin(0.03 * k), 0.03 * math.sin(0.045 * k), distance]
        poses.append(numpy.column_stack([rotation, centre]))
    return poses


def held_by(poses, place):
    """What stays at `place` (4x4, object frame) of an object with these poses."""
    return [pose @ place for pose in poses]
