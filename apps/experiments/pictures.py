"""Pictures of the pixels used and rejected, of frames that stand for what happens in a sequence."""

import matplotlib.image

import measures
from work import tracker_options

STEPS = 4
TRACKERS = ("paper", "default")
QUARTER = 0.25


def chosen_frames(rows):
    """The frame before anything hides the box, the half-hidden one before the most hidden, that one, and the last."""
    visible = [measures.number(row, "visible") for row in rows]
    least = min(range(len(rows)), key=visible.__getitem__)
    most_seen = max(visible[:least] or visible)
    middle = 0.5 * (visible[least] + most_seen)
    half = max(i for i in range(least + 1) if visible[i] >= middle)
    # The pixels of a box that is wholly hidden are no picture: the last frame before, with a quarter left.
    hidden = least if visible[least] > QUARTER else max(i for i in range(least + 1) if visible[i] > QUARTER)
    return sorted({half, hidden})


def draw(work, folders, scenario, images):
    for scene in ("bar", "cube"):
        for tracker in TRACKERS:
            folder = folders[scene][0]
            options = tracker_options(scenario["trackers"][tracker])
            rows = work.run("{}/{}".format(scene, tracker), folders[scene], options).frames()[0]
            frames = chosen_frames(rows)
            out = work.folder / "pictures" / scene / tracker
            work.run("pictures/{}-{}".format(scene, tracker), [folder], options,
                     ["--pictures", out, "--picture-frames", ",".join(map(str, frames))])
            for name, frame in zip(("half", "hidden"), frames):
                picture = matplotlib.image.imread(out / "{}_step1_{:06d}.png".format(folder.name, frame))
                matplotlib.image.imsave(images / "pixels_{}_{}_{}.jpg".format(scene, tracker, name), picture,
                                        pil_kwargs={"quality": 80})
