"""Models of very different kinds, made by rule: OBJ, MTL and PNG. Metres; y up, the front towards +z."""

import math

import numpy
from PIL import Image, ImageDraw


class Model:
    """Triangles with texture coordinates: points (n, 3), coordinates (m, 2), corners (k, 3, 2) of indices of both,
    a material a triangle; pictures by material."""

    def __init__(self, points, coordinates, corners, materials=None, pictures=()):
        self.points = numpy.asarray(points, float)
        self.coordinates = numpy.asarray(coordinates, float)
        self.corners = numpy.asarray(corners, int)
        self.materials = numpy.zeros(len(self.corners), int) if materials is None else numpy.asarray(materials, int)
        self.pictures = list(pictures)

    def normals(self):
        """Of the triangles, of unit length; zeros where one has no area."""
        a, b, c = (self.points[self.corners[:, i, 0]] for i in range(3))
        normals = numpy.cross(b - a, c - a)
        lengths = numpy.linalg.norm(normals, axis=1, keepdims=True)
        return numpy.divide(normals, lengths, out=numpy.zeros_like(normals), where=lengths > 0)

    def inflated(self, distance):
        """Every point moved outwards along the mean of its triangles' directions, weighed by their angles there, so that
        the diagonal that a face is cut along does not matter."""
        outwards = numpy.zeros_like(self.points)
        normals = self.normals()
        corner = [self.points[self.corners[:, i, 0]] for i in range(3)]
        for i in range(3):
            a, b = corner[(i + 1) % 3] - corner[i], corner[(i + 2) % 3] - corner[i]
            cosines = (a * b).sum(1) / numpy.maximum(numpy.linalg.norm(a, axis=1) * numpy.linalg.norm(b, axis=1), 1e-15)
            angles = numpy.arccos(numpy.clip(cosines, -1, 1))
            numpy.add.at(outwards, self.corners[:, i, 0], angles[:, None] * normals)
        # Seams of the texture double points: all at one place go the same way.
        _, place = numpy.unique(self.points.round(9), axis=0, return_inverse=True)
        place = place.reshape(-1)
        together = numpy.zeros((place.max() + 1, 3))
        numpy.add.at(together, place, outwards)
        together /= numpy.maximum(numpy.linalg.norm(together, axis=1, keepdims=True), 1e-12)
        return Model(self.points + distance * together[place], self.coordinates, self.corners, self.materials,
                     self.pictures)

    def write(self, folder):
        """folder/model.obj with its materials. Returns its path."""
        folder.mkdir(parents=True, exist_ok=True)
        with open(folder / "model.mtl", "w", encoding="utf-8") as file:
            for i, picture in enumerate(self.pictures):
                picture.save(folder / "texture{}.png".format(i))
                file.write("newmtl m{0}\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd texture{0}.png\n".format(i))
        with open(folder / "model.obj", "w", encoding="utf-8") as file:
            file.write("mtllib model.mtl\n")
            file.writelines("v {:.7f} {:.7f} {:.7f}\n".format(*point) for point in self.points)
            file.writelines("vt {:.7f} {:.7f}\n".format(*pair) for pair in self.coordinates)
            for material in range(len(self.pictures)):
                file.write("usemtl m{}\n".format(material))
                for triangle in self.corners[self.materials == material] + 1:
                    file.write("f {}/{} {}/{} {}/{}\n".format(*triangle.reshape(-1)))
        return folder / "model.obj"

    def write_shape(self, folder):
        """folder/shape.obj: points and triangles, nothing on them. Returns its path."""
        folder.mkdir(parents=True, exist_ok=True)
        with open(folder / "shape.obj", "w", encoding="utf-8") as file:
            file.writelines("v {:.7f} {:.7f} {:.7f}\n".format(*point) for point in self.points)
            file.writelines("f {} {} {}\n".format(*triangle) for triangle in self.corners[:, :, 0] + 1)
        return folder / "shape.obj"


def read(path):
    """An OBJ file of triangles with one texture, as `write` makes them and the recorded sequences' models are."""
    points, coordinates, corners = [], [], []
    for line in path.read_text(encoding="utf-8").splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            points.append([float(word) for word in words[1:4]])
        elif words[:1] == ["vt"]:
            coordinates.append([float(word) for word in words[1:3]])
        elif words[:1] == ["f"]:
            pairs = [[int(index) - 1 for index in word.split("/")[:2]] for word in words[1:]]
            corners += [[pairs[0], pairs[i], pairs[i + 1]] for i in range(1, len(pairs) - 1)]
    materials = path.with_suffix(".mtl").read_text(encoding="utf-8").split()
    textures = [materials[i + 1] for i, word in enumerate(materials[:-1]) if word == "map_Kd"]
    return Model(points, coordinates, corners, None, [Image.open(path.parent / textures[0]).convert("RGB")])


def print_of(seed, width=768, height=768, size=1.0):
    """A picture as on packages and toys: patches, rings, strokes and letters of all sizes."""
    random = numpy.random.default_rng(seed)
    picture = Image.new("RGB", (width, height), tuple(int(v) for v in random.integers(110, 190, 3)))
    draw = ImageDraw.Draw(picture)
    for i in range(260):
        reach = size * 0.5 * width * 10 ** random.uniform(-1.7, -0.5 if i < 60 else -1.0)
        x, y = random.uniform(0, width), random.uniform(0, height)
        color = tuple(int(v) for v in random.integers(15, 240, 3))
        box = [x - reach, y - reach * random.uniform(0.3, 1), x + reach, y + reach * random.uniform(0.3, 1)]
        kind = random.integers(0, 4)
        if kind == 0:
            draw.rectangle(box, fill=color)
        elif kind == 1:
            draw.ellipse(box, fill=color)
        elif kind == 2:
            draw.ellipse(box, outline=color, width=max(2, int(reach / 5)))
        else:
            draw.line([box[0], box[1], box[2], box[3]], fill=color, width=max(2, int(reach / 6)))
    for i in range(60):
        word = "".join(chr(int(c)) for c in random.integers(65, 91, 4))
        letters = Image.new("L", (26, 12), 0)
        ImageDraw.Draw(letters).text((1, 0), word, fill=255)
        scale = size * random.uniform(2, 7) * width / 768
        letters = letters.resize((int(26 * scale), int(12 * scale)), Image.BILINEAR).rotate(
            float(random.uniform(0, 360)), expand=True)
        color = tuple(int(v) for v in random.integers(0, 256, 3))
        picture.paste(color, (int(random.uniform(0, width)), int(random.uniform(0, height))), letters)
    return picture


def turned(profile, sides):
    """A closed solid: (radius, height) points turned about the y axis, texture once round."""
    profile = numpy.asarray(profile, float)
    along = numpy.concatenate([[0], numpy.cumsum(numpy.linalg.norm(numpy.diff(profile, axis=0), axis=1))])
    along /= along[-1]
    points, coordinates, corners = [], [], []
    for i in range(sides + 1):
        angle = 2 * math.pi * i / sides
        for (radius, height), v in zip(profile, along):
            points.append([radius * math.sin(angle), height, radius * math.cos(angle)])
            coordinates.append([i / sides, v])
    rows = len(profile)
    for i in range(sides):
        for j in range(rows - 1):
            a, b = i * rows + j, (i + 1) * rows + j
            for triangle in ([a, b, b + 1], [a, b + 1, a + 1]):
                if len({tuple(numpy.round(points[k], 9)) for k in triangle}) == 3:
                    corners.append([[k, k] for k in triangle])
    return points, coordinates, corners


def vase(seed):
    """Curved, with a waist."""
    heights = numpy.linspace(-0.08, 0.08, 60)
    radii = 0.042 + 0.014 * numpy.sin(3.4 * heights / 0.08 + 0.6)
    profile = [[0, -0.08], *zip(radii, heights), [0, 0.08]]
    return Model(*turned(profile, 72), pictures=[print_of(seed, 1024, 768)])


def can(seed):
    """A cylinder."""
    profile = [[0, -0.06], [0.033, -0.06], [0.033, 0.06], [0, 0.06]]
    return Model(*turned(profile, 48), pictures=[print_of(seed, 1024, 768)])


def bowl(seed):
    """Concave: one sees into it."""
    angles = numpy.linspace(0, 0.48 * math.pi, 24)
    outer = [[0.08 * math.sin(a), -0.08 * math.cos(a)] for a in angles]
    inner = [[0.074 * math.sin(a), -0.074 * math.cos(a) + 0.001] for a in angles[::-1]]
    return Model(*turned(outer + inner, 72), pictures=[print_of(seed, 1024, 1024)])


def prism(outline, depth, seed, pictures=1, picture_size=512):
    """An outline in x and y (anticlockwise, starshaped about its first point) of this depth; each face has its own place
    in a texture, or its own texture."""
    outline = numpy.asarray(outline, float)
    count = len(outline)
    faces = [[(x, y, depth / 2) for x, y in outline], [(x, y, -depth / 2) for x, y in outline[::-1]]]
    # The front begins at the point that sees all others; reversed, that one is last.
    faces[1] = faces[1][-1:] + faces[1][:-1]
    for i in range(count):
        (x0, y0), (x1, y1) = outline[i], outline[(i + 1) % count]
        faces.append([(x0, y0, -depth / 2), (x1, y1, -depth / 2), (x1, y1, depth / 2), (x0, y0, depth / 2)])
    columns = math.ceil(math.sqrt(len(faces))) if pictures == 1 else 1
    points, coordinates, corners, materials = [], [], [], []
    for f, face in enumerate(faces):
        face = numpy.asarray(face)
        right = (face[1] - face[0]) / numpy.linalg.norm(face[1] - face[0])
        normal = numpy.cross(face[1] - face[0], face[2] - face[0])
        up = numpy.cross(normal / numpy.linalg.norm(normal), right)
        flat = numpy.stack([(face - face[0]) @ right, (face - face[0]) @ up], 1)
        flat -= flat.min(0)
        flat = 0.02 + 0.96 * flat / flat.max()
        cell = numpy.array([f % columns, f // columns]) if pictures == 1 else numpy.zeros(2)
        first = len(points)
        points += list(face)
        coordinates += list((flat + cell) / columns)
        corners += [[[first, first], [first + i, first + i], [first + i + 1, first + i + 1]]
                    for i in range(1, len(face) - 1)]
        materials += [f % pictures] * (len(face) - 2)
    return Model(points, coordinates, corners, materials,
                 [print_of(seed + i, picture_size, picture_size) for i in range(pictures)])


def rectangle(width, height):
    return [(-width / 2, -height / 2), (width / 2, -height / 2), (width / 2, height / 2), (-width / 2, height / 2)]


def crate(seed):
    return prism(rectangle(0.14, 0.1), 0.08, seed, picture_size=1024)


def bracket(seed):
    """Concave, of planes: an L."""
    outline = [(-0.02, -0.02), (-0.02, 0.06), (-0.06, 0.06), (-0.06, -0.06), (0.06, -0.06), (0.06, -0.02)]
    return prism(outline, 0.07, seed, picture_size=1024)


def card(seed):
    """Thin: two millimetres."""
    return prism(rectangle(0.13, 0.09), 0.002, seed, picture_size=1024)


def materials(seed):
    """Twelve sides and two ends, each with a material of its own."""
    outline = [(0.05 * math.cos(a), 0.07 * math.sin(a)) for a in numpy.arange(12) * math.pi / 6]
    return prism(outline, 0.08, seed, pictures=14, picture_size=256)


def coarse(seed):
    """A box whose texture has a texel for every three or four millimetres."""
    model = crate(seed)
    model.pictures = [picture.resize((96, 96), Image.BOX) for picture in model.pictures]
    return model


def rock(seed, rows):
    """A ball with dents, of 4 * rows * (rows - 1) triangles."""
    random = numpy.random.default_rng(seed)
    directions = random.normal(size=(12, 3))
    directions /= numpy.linalg.norm(directions, axis=1, keepdims=True)
    depths, widths = random.uniform(-0.012, 0.012, 12), random.uniform(3, 12, 12)
    columns = 2 * rows
    polar = numpy.linspace(0, math.pi, rows + 1)
    around = numpy.linspace(0, 2 * math.pi, columns + 1)
    a, p = numpy.meshgrid(around, polar, indexing="ij")
    unit = numpy.stack([numpy.sin(p) * numpy.sin(a), -numpy.cos(p), numpy.sin(p) * numpy.cos(a)], -1).reshape(-1, 3)
    radius = 0.06 + (depths * numpy.exp(widths * (unit @ directions.T - 1))).sum(1)
    coordinates = numpy.stack([a / (2 * math.pi), p / math.pi], -1).reshape(-1, 2)
    first = (numpy.arange(columns)[:, None] * (rows + 1) + numpy.arange(rows)[None, :]).reshape(-1)
    next_ = first + rows + 1
    low = numpy.stack([first, next_, next_ + 1], 1)[first % (rows + 1) > 0]
    high = numpy.stack([first, next_ + 1, first + 1], 1)[first % (rows + 1) < rows - 1]
    triangles = numpy.concatenate([low, high])
    return Model(radius[:, None] * unit, coordinates, numpy.stack([triangles, triangles], -1),
                 pictures=[print_of(seed, 1536, 1024)])


def rock_10k(seed):
    return rock(seed, 51)


def rock_500k(seed):
    return rock(seed, 354)


def printed_only_at(model, places, color):
    """Of the print only these rectangles (least and most u and v) are left, on plain material."""
    picture = model.pictures[0]
    plain = Image.new("RGB", picture.size, color)
    for u0, v0, u1, v1 in places:
        box = (int(u0 * picture.width), int((1 - v1) * picture.height), int(u1 * picture.width),
               int((1 - v0) * picture.height))
        plain.paste(picture.crop(box), box)
    return Model(model.points, model.coordinates, model.corners, None, [plain])


def on_face(model, triangle, share):
    """The middle of a rectangular face's place in the texture, this share of its sides."""
    corners = model.coordinates[model.corners[triangle][:, 1]]
    middle, half = (corners.min(0) + corners.max(0)) / 2, share * (corners.max(0) - corners.min(0)) / 2
    return (*(middle - half), *(middle + half))


def labelled_crate(seed):
    """Plain but for a label on its front."""
    model = crate(seed)
    return printed_only_at(model, [on_face(model, 0, 0.35)], (150, 110, 70))


def labelled_bracket(seed):
    """Plain but for labels on two sides."""
    model = bracket(seed)
    last = len(model.corners) - 1
    return printed_only_at(model, [on_face(model, last, 0.6), on_face(model, last - 4, 0.6)], (90, 95, 100))


def mug(seed):
    """Printed on two fifths of its side; a handle."""
    body = can(seed)
    points, coordinates, corners = map(list, (body.points, body.coordinates, body.corners))
    plain = len(coordinates)
    coordinates.append([0.4, 0.5])
    for x0, x1, y0, y1 in ((0.031, 0.056, 0.024, 0.034), (0.031, 0.056, -0.034, -0.024), (0.048, 0.058, -0.034, 0.034)):
        first = len(points)
        points += [[x, y, z] for x in (x0, x1) for y in (y0, y1) for z in (-0.005, 0.005)]
        for a, b, c, d in ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)):
            corners += [[[first + i, plain] for i in triangle] for triangle in ((a, b, c), (a, c, d))]
    model = Model(points, coordinates, corners, None, body.pictures)
    return printed_only_at(model, [(0, 0.3, 0.12, 0.75), (0.7, 0.3, 1, 0.75)], (200, 200, 190))


def ringed(model, seed):
    """Printed with nothing but rings about the axis."""
    random = numpy.random.default_rng(seed)
    rings = numpy.zeros((model.pictures[0].height, 1, 3))
    y = 0
    while y < len(rings):
        height = int(random.integers(15, 70))
        rings[y:y + height] = random.integers(20, 235, 3)
        y += height
    picture = Image.fromarray(rings.astype(numpy.uint8)).resize(model.pictures[0].size, Image.NEAREST)
    return Model(model.points, model.coordinates, model.corners, None, [picture])


def ringed_can(seed):
    return ringed(can(seed), seed)


def ringed_vase(seed):
    return ringed(vase(seed), seed)


def labelled_rock(seed):
    """Plain but for two labels."""
    return printed_only_at(rock_10k(seed), [(0.05, 0.35, 0.25, 0.6), (0.6, 0.5, 0.7, 0.7)], (120, 130, 90))


def fingers(seed):
    """Three fingers side by side and no more, pointing up, 18 mm thick, 120 mm long, about the origin."""
    points, coordinates, corners = [], [], []
    angles = numpy.linspace(0, math.pi / 2, 8)
    tip = [[0.0075 * math.cos(a), 0.05 + 0.0075 * math.sin(a)] for a in angles]
    for x in (-0.017, 0.0, 0.017):
        more = turned([[0, -0.1], [0.0075, -0.1], *tip], 24)
        offset = len(points)
        points += [[x + px, py + 0.004 * (x == 0), pz] for px, py, pz in more[0]]
        coordinates += more[1]
        corners += [[[i + offset, j + offset] for i, j in triangle] for triangle in more[2]]
    random = numpy.random.default_rng(seed)
    skin = numpy.clip(numpy.array([205, 150, 125]) + random.normal(0, 1, (16, 16, 1)) * [9, 9, 9], 0, 255)
    picture = Image.fromarray(skin.astype(numpy.uint8)).resize((128, 128), Image.BICUBIC)
    return Model(1.2 * numpy.asarray(points), coordinates, corners, pictures=[picture])


KINDS = {
    "vase": vase, "can": can, "bowl": bowl, "crate": crate, "bracket": bracket, "card": card, "materials": materials,
    "coarse": coarse, "labelled-crate": labelled_crate, "labelled-bracket": labelled_bracket, "mug": mug,
    "ringed-can": ringed_can, "ringed-vase": ringed_vase,
    "labelled-rock": labelled_rock, "rock-10k": rock_10k, "rock-500k": rock_500k, "fingers": fingers,
}
