"""Copies of models and sequences whose light, tone and colours have come apart."""

import shutil

import numpy
from PIL import Image, ImageDraw

import models


def with_curve(picture, curve):
    """`curve` from [0, 1] to [0, 1], a value or one a channel."""
    values = numpy.asarray(picture.convert("RGB"), float) / 255
    return Image.fromarray(numpy.clip(255 * curve(values) + 0.5, 0, 255).astype(numpy.uint8))


def curved_model(path, folder, curve):
    model = models.read(path)
    model.pictures = [with_curve(picture, curve) for picture in model.pictures]
    return model.write(folder)


def shaded_model(path, folder, lamp, least):
    """The texture darkened by how far each face looks away from a lamp in this direction (object axes)."""
    model = models.read(path)
    lamp = numpy.asarray(lamp, float) / numpy.linalg.norm(lamp)
    light = least + (1 - least) * numpy.maximum(0, model.normals() @ lamp)
    picture = model.pictures[0]
    width, height = picture.size
    mask = Image.new("L", picture.size, 255)
    draw = ImageDraw.Draw(mask)
    place = model.coordinates * [width, -height] + [-0.5, height - 0.5]
    for triangle, share in zip(model.corners[:, :, 1], light):
        draw.polygon([tuple(place[k]) for k in triangle], fill=int(255 * share + 0.5), outline=int(255 * share + 0.5))
    shares = numpy.asarray(mask, float)[:, :, None] / 255
    model.pictures = [with_curve(picture, lambda values: values * shares)]
    return model.write(folder)


def changed_sequence(source, folder, change):
    """A sequence whose frames `change` makes another of."""
    (folder / "frames").mkdir(parents=True, exist_ok=True)
    for name in ("K.txt", "poses_gt.txt", "visible.txt"):
        shutil.copyfile(source / name, folder / name)
    for frame in sorted((source / "frames").iterdir()):
        with Image.open(frame) as picture:
            change(picture).save(folder / "frames" / (frame.stem + ".jpg"), quality=97, subsampling=0)
    return folder


def curved_sequence(source, folder, curve):
    """Of frames that went through `curve`."""
    return changed_sequence(source, folder, lambda picture: with_curve(picture, curve))


def grey_sequence(source, folder):
    """Of frames of one channel."""
    return changed_sequence(source, folder, lambda picture: picture.convert("L"))
