"""Scenes in which a tracker may hold a wrong pose, drawn by casting rays at boxes, cylinders and ellipsoids.

Shares no code with the tracker or with `holdfast simulate`. Metres, camera axes x right, y down, z forward; a pose is
3x4 and maps the shape's frame to the camera's. Times are frames, 30 a second.
"""

import dataclasses

import cv2
import numpy as np

WIDTH, HEIGHT, FINE = 640, 480, 2  # FINE: rays a pixel along x and along y
FOCAL, CENTER = 650.0, ((WIDTH - 1) / 2, (HEIGHT - 1) / 2)
SKIN = np.array([118.0, 150.0, 205.0])  # BGR, as all colours here


# ---- Shapes. hit(o, d): the distances s at which rays o + s d enter and leave, and those at which they enter the bodies
# that the shape is the common part of. look(p, d, entries): normals and colours where they enter.

def round_entry(o, d, axes):
    """Where rays enter and leave a sphere or an endless cylinder of radius 1 over these axes."""
    a, b, c = (sum(p[..., k] * q[..., k] for k in axes) for p, q in ((d, d), (o, d), (o, o)))
    inside = b * b - a * (c - 1)
    root = np.sqrt(np.maximum(inside, 0))
    return np.where(inside > 0, (-b - root) / a, np.float32(np.inf)), (-b + root) / a


def slab(o, d, half):
    """Where rays enter and leave the space between -half and half, along one axis."""
    inverse = 1 / np.where(np.abs(d) < 1e-7, np.float32(1e-7), d)
    middle, reach = -o * inverse, half * np.abs(inverse)
    return middle - reach, middle + reach


class Box:
    """Between -half and half. Colours of faces -x, +x, -y, +y, -z, +z (6x3), or an atlas of 3x2 cells in this order."""

    def __init__(self, half, colors=None, atlas=None):
        self.half, self.atlas = np.array(half, np.float32), atlas
        self.colors = None if colors is None else np.broadcast_to(np.array(colors, float), (6, 3))
        self.reach = np.linalg.norm(self.half)

    def hit(self, o, d):
        pairs = [slab(o[k], d[..., k], self.half[k]) for k in range(3)]
        near, far = np.maximum.reduce([pair[0] for pair in pairs]), np.minimum.reduce([pair[1] for pair in pairs])
        return near, far, [pair[0] for pair in pairs]

    def look(self, p, d, entries):
        axis = np.argmax(entries, axis=0)
        rows = np.arange(len(p))
        sign = -np.sign(d[rows, axis])
        normal = np.zeros_like(p)
        normal[rows, axis] = sign
        face = 2 * axis + (sign > 0)
        if self.atlas is None:
            return normal, self.colors[face]
        across, along = (axis + 1) % 3, (axis + 2) % 3
        inside = np.stack([p[rows, k] / self.half[k] / 2 + 0.5 for k in (across, along)], axis=-1)
        return normal, sample(self.atlas, self.cell(face, inside))

    @staticmethod
    def cell(face, inside):
        """Coordinates in the atlas, [0, 1], y down, of a point inside a face; cells have a margin of printed border."""
        return (np.stack([face % 3, face // 3], axis=-1) + 0.03 + 0.94 * inside) / (3, 2)

    def mesh(self):
        """Polygons of four corners, each corner with coordinates in the atlas."""
        polygons = []
        for face in range(6):
            axis, sign = face // 2, 2 * (face % 2) - 1
            corners = []
            for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))[::sign]:
                p = np.zeros(3)
                p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = sign, 2 * a - 1, 2 * b - 1
                corners.append((p * self.half, self.cell(np.array(face), np.array([a, b]))))
            polygons.append(corners)
        return polygons

    def symmetries(self):
        """Rotations that map the shape without its print to itself."""
        found = []
        for order in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (1, 0, 2), (0, 2, 1), (2, 1, 0)):
            if not np.allclose(self.half[list(order)], self.half):
                continue
            for signs in np.ndindex(2, 2, 2):
                R = np.eye(3)[list(order)] * (1 - 2 * np.array(signs))
                if np.linalg.det(R) > 0:
                    found.append(R)
        return found


class Cylinder:
    """About y. One colour, or a label: the upper 7/8 of a picture go round, the rest is the ends' look."""

    def __init__(self, radius, half_height, color=None, label=None, end=None):
        self.radius, self.half_height, self.label = radius, half_height, label
        self.color = None if color is None else np.array(color, float)
        self.end = self.color if end is None else np.array(end, float)
        self.reach = np.hypot(radius, half_height)

    def hit(self, o, d):
        near, far = round_entry(o / self.radius, d / self.radius, (0, 2))
        first, last = slab(o[1], d[..., 1], self.half_height)
        return np.maximum(near, first), np.minimum(far, last), [near, first]

    def look(self, p, d, entries):
        at_end = entries[1] > entries[0]
        normal = np.where(at_end[:, None], np.stack([0 * p[:, 0], -np.sign(d[:, 1]), 0 * p[:, 0]], -1),
                          p * (1, 0, 1) / self.radius)
        if self.label is None:
            return normal, np.where(at_end[:, None], self.end, self.color)
        turn = np.arctan2(p[:, 0], p[:, 2]) / (2 * np.pi) + 0.5
        down = (p[:, 1] / self.half_height / 2 + 0.5) * 0.875
        return normal, sample(self.label, np.where(at_end[:, None], (0.5, 0.95), np.stack([turn, down], -1)))

    def mesh(self, around=96):
        angles = 2 * np.pi * (np.arange(around) / around - 0.5)
        ring = list(zip(self.radius * np.sin(angles), self.radius * np.cos(angles)))
        top, bottom, end = -self.half_height, self.half_height, np.array([0.5, 0.95])
        polygons = []
        for i in range(around):
            (x, z), (x2, z2) = ring[i], ring[(i + 1) % around]
            corners = [((x, bottom, z), (i / around, 0.875)), ((x, top, z), (i / around, 0)),
                       ((x2, top, z2), ((i + 1) / around, 0)), ((x2, bottom, z2), ((i + 1) / around, 0.875))]
            polygons.append([(np.array(p), np.array(c)) for p, c in corners])
        polygons.append([(np.array((x, top, z)), end) for x, z in ring[::-1]])
        polygons.append([(np.array((x, bottom, z)), end) for x, z in ring])
        return polygons

    def symmetries(self):
        """The turn about y is left to who measures."""
        return [np.eye(3), np.diag([1.0, -1.0, -1.0])]


class Ellipsoid:
    def __init__(self, radii, color):
        self.radii, self.color, self.reach = np.array(radii, np.float32), np.array(color, float), max(radii)

    def hit(self, o, d):
        near, far = round_entry(o / self.radii, d / self.radii, (0, 1, 2))
        return near, far, [near]

    def look(self, p, d, entries):
        del d, entries
        normal = p / self.radii ** 2
        folds = 1 + 0.05 * np.sin(p @ (430, 290, 510)) + 0.04 * np.sin(p @ (-170, 610, 230))
        return normal / np.linalg.norm(normal, axis=1, keepdims=True), self.color * folds[:, None]


def sample(picture, where):
    x, y = (where * np.array(picture.shape[1::-1]) - 0.5).astype(np.float32).T
    flat = [cv2.remap(picture, x[i:i + 30000, None], y[i:i + 30000, None], cv2.INTER_LINEAR,
                      borderMode=cv2.BORDER_REPLICATE)[:, 0] for i in range(0, len(x), 30000)]
    return np.concatenate(flat).astype(float)


# ---- Drawing

@dataclasses.dataclass
class Scene:
    shape: object  # the tracked one
    pose: object  # time -> 3x4
    frames: int
    others: object = lambda time: []  # time -> [(shape, pose)]: what hides it
    has_print: bool = False  # in the model too
    model_shape: object = None  # where the model's print is another
    shutter: float = 0  # of a frame
    blur: float = 0.5  # sigma, pixels
    gone_from: int = 10**9  # the frame from which on it is not there
    shadow: bool = False


def region(shape, pose, fine, clipped=True):
    """Columns and rows that may see the shape, and the rays through them."""
    x, y, z = pose[:, 3]
    r = 1.02 * FOCAL * shape.reach / max(z - shape.reach, 0.05)
    u, v = FOCAL * x / z + CENTER[0], FOCAL * y / z + CENTER[1]
    low, high = np.floor(fine * np.array([u - r, v - r])), np.ceil(fine * np.array([u + r, v + r]))
    if clipped:
        low, high = (np.clip(end, 0, fine * np.array([WIDTH, HEIGHT])) for end in (low, high))
    columns, rows = (np.arange(int(a), max(int(a), int(b))) for a, b in zip(low, high))
    x, y = (((k + 0.5) / fine - 0.5 - c) / FOCAL for k, c in zip((columns, rows), CENTER))
    grid = np.meshgrid(x.astype(np.float32), y.astype(np.float32))
    return columns, rows, np.stack([*grid, np.ones_like(grid[0])], axis=-1)


def cast(shape, pose, rays):
    R, t = pose[:, :3].astype(np.float32), pose[:, 3].astype(np.float32)
    o, d = -R.T @ t, rays @ R
    near, far, entries = shape.hit(o, d)
    return o, d, near, (near < far) & (near > 0), entries


def draw(picture, items, lamp):
    """Puts shapes on a fine picture; returns which item each fine pixel shows (-1: none)."""
    depth, shows = np.full(picture.shape[:2], np.inf, np.float32), np.full(picture.shape[:2], -1, np.int8)
    for number, (shape, pose) in enumerate(items):
        columns, rows, rays = region(shape, pose, FINE)
        if not len(columns) or not len(rows):
            continue
        window = np.s_[rows[0]:rows[-1] + 1, columns[0]:columns[-1] + 1]
        o, d, near, hit, entries = cast(shape, pose, rays)
        hit &= near < depth[window]
        d, near, entries = d[hit], near[hit], [entry[hit] for entry in entries]
        if not len(d):
            continue
        normal, color = shape.look(o + near[:, None] * d, d, entries)
        normal = normal @ pose[:, :3].T
        shade = 0.62 + 0.45 * np.maximum(normal @ lamp, 0) - 0.08 * normal[:, 1]
        picture[window][hit] = color * shade[:, None]
        depth[window][hit] = near
        shows[window][hit] = number
    return shows


def background(rng):
    """Clutter, a tenth larger than the fine picture."""
    h, w = (int(1.1 * FINE * n) for n in (HEIGHT, WIDTH))
    low = cv2.resize(rng.uniform(40, 210, (6, 8, 3)).astype(np.float32), (w, h), interpolation=cv2.INTER_CUBIC)
    picture = 0.5 * low + rng.uniform(50, 170, 3) * 0.5
    for _ in range(70):
        color = (0.6 * rng.uniform(10, 245) + 0.4 * rng.uniform(10, 245, 3)).tolist()
        at = rng.uniform((0, 0), (w, h))
        size = rng.uniform(10, 130, 2) * rng.uniform(0.3, 1)
        layer = picture.copy()
        if rng.random() < 0.6:
            corners = cv2.boxPoints((at.tolist(), (2 * size).tolist(), rng.uniform(0, 90)))
            cv2.fillConvexPoly(layer, corners.astype(np.int32), color)
        else:
            cv2.ellipse(layer, (at.tolist(), (2 * size).tolist(), rng.uniform(0, 180)), color, -1)
        picture = cv2.addWeighted(layer, 0.8, picture, 0.2, 0)
    grain = cv2.resize(rng.normal(0, 8, (h // 5, w // 5, 1)).astype(np.float32), (w, h))
    return cv2.GaussianBlur(np.clip(picture + grain[..., None], 0, 255).astype(np.float32), (0, 0), 2.5)


def shadow_on(picture, pose):
    """A soft one, to the right of where the shape is seen."""
    u = (FOCAL * pose[:2, 3] / pose[2, 3] + CENTER + (38, 14)) * FINE
    along = FOCAL * pose[:2, 1] * 0.075 / pose[2, 3] * FINE
    length = max(np.linalg.norm(along), 1.0)
    y, x = np.mgrid[0:picture.shape[0], 0:picture.shape[1]].astype(np.float32)
    x, y = x - u[0], y - u[1]
    a, b = (x * along[0] + y * along[1]) / length, (x * along[1] - y * along[0]) / length
    picture *= (1 - 0.4 * np.exp(-0.5 * ((a / length / 0.8) ** 2 + (b / 45) ** 2)))[..., None]


class Renderer:
    def __init__(self, scene, seed):
        self.scene, self.rng = scene, np.random.default_rng([*seed, 99])
        self.ground, self.drift = background(self.rng), Sway(self.rng, [14, 10], 0.2)
        lamp = self.rng.uniform((-0.8, -1, -1), (0.8, -0.4, -0.4))
        self.lamp = lamp / np.linalg.norm(lamp)

    def frame(self, number):
        """The picture, and the visible share of the silhouette."""
        scene, total, share = self.scene, 0, 0
        times = number + scene.shutter * (np.array([-0.375, -0.125, 0.125, 0.375]) if scene.shutter else np.zeros(1))
        there = number < scene.gone_from
        move = np.hstack([np.eye(2), (-30 - self.drift(number))[:, None]])
        ground = cv2.warpAffine(self.ground, move, (FINE * WIDTH, FINE * HEIGHT))
        for time in times:
            fine, pose = ground.copy(), scene.pose(time)
            if scene.shadow:
                shadow_on(fine, pose)
            items = ([(scene.shape, pose)] if there else []) + scene.others(time)
            shows = draw(fine, items, self.lamp)
            if there:
                silhouette = cast(scene.shape, pose, region(scene.shape, pose, FINE, clipped=False)[2])[3].sum()
                share += (shows == 0).sum() / silhouette / len(times)
            total = total + cv2.resize(fine, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA) / np.float32(len(times))
        total = cv2.GaussianBlur(total, (0, 0), scene.blur) + 2 * self.rng.standard_normal(total.shape, np.float32)
        return np.clip(np.round(total), 0, 255).astype(np.uint8), min(share, 1.0)


# ---- Motion and print

class Sway:
    """Smooth motion of several numbers, in sums of sines of up to `fastest` Hz, within about the amplitudes."""

    def __init__(self, rng, amplitudes, fastest):
        n = len(amplitudes)
        self.amplitudes = np.array(amplitudes) * rng.uniform(0.3, 0.6, (3, n))
        self.rates = 2 * np.pi / 30 * fastest * rng.uniform(0.3, 1, (3, n))
        self.phases = rng.uniform(0, 2 * np.pi, (3, n))

    def __call__(self, time):
        return (self.amplitudes * np.sin(self.rates * time + self.phases)).sum(axis=0)


def rotation(*degrees):
    """By a rotation vector."""
    return cv2.Rodrigues(np.radians(np.array(degrees, float)))[0]


def pose_of(R, t):
    return np.hstack([R, np.array(t, float)[:, None]])


def print_of(rng, width, height, contrast, shapes=26):
    """A package's print: blocks, discs and words on one ground."""
    ground = rng.uniform(90, 200, 3)
    picture = np.full((height, width, 3), ground, np.float32)
    for _ in range(shapes):
        color = (ground + contrast * (rng.uniform(5, 250, 3) - ground)).tolist()
        x, y = (int(k) for k in rng.uniform(0, (width, height)))
        a, b = (int(k) for k in rng.uniform(0.03, 0.14, 2) * min(width, height))
        kind = rng.random()
        if kind < 0.4:
            cv2.rectangle(picture, (x - a, y - b), (x + a, y + b), color, -1)
        elif kind < 0.7:
            cv2.ellipse(picture, (x, y), (a, b), 0, 0, 360, color, -1)
        else:
            word = "".join(chr(k) for k in rng.integers(65, 91, 5))
            cv2.putText(picture, word, (x - 40, y), cv2.FONT_HERSHEY_DUPLEX, rng.uniform(0.7, 1.8), color, 3)
    return cv2.GaussianBlur(picture, (0, 0), 0.8)


def atlas_of(rng, contrast):
    """Cells of 384 x 384 pixels for the faces of a box."""
    cells = [print_of(rng, 384, 384, contrast) for _ in range(6)]
    return np.vstack([np.hstack(cells[:3]), np.hstack(cells[3:])])


def write_model(folder, shape, picture):
    """model.obj, with model.mtl and model.png where there is a picture."""
    folder.mkdir(parents=True)
    points, coordinates, faces = {}, [], []
    for polygon in shape.mesh():
        corners = []
        for p, c in polygon:
            corner = str(points.setdefault("v {:.6f} {:.6f} {:.6f}".format(*(p + 0.0)), len(points) + 1))
            coordinates.append("vt {:.6f} {:.6f}".format(c[0], 1 - c[1]))
            corners.append(corner if picture is None else "{}/{}".format(corner, len(coordinates)))
        faces.append("f " + " ".join(corners))
    head = []
    if picture is not None:
        cv2.imwrite(str(folder / "model.png"), picture)
        (folder / "model.mtl").write_text("newmtl print\nKd 1 1 1\nmap_Kd model.png\n")
        head = ["mtllib model.mtl", "usemtl print"]
    (folder / "model.obj").write_text("\n".join([*head, *points, *(coordinates if head else []), *faces]) + "\n")
