"""Pictures of the pixels used and rejected, of a half-hidden box."""

import matplotlib.image

import measures
from work import tracker_options

STEPS = 4
TRACKERS = ("paper", "default")


def half_hidden(rows):
    """The last frame before the most hidden one in which half of what is hidden then is still seen."""
    visible = [measures.number(row, "visible") for row in rows]
    least = min(range(len(rows)), key=visible.__getitem__)
    middle = 0.5 * (visible[least] + max(visible[:least] or visible))
    return max(i for i in range(least + 1) if visible[i] >= middle)


def draw(work, folders, scenario, images):
    for scene in ("bar", "cube"):
        for tracker in TRACKERS:
            folder = folders[scene][0]
            options = tracker_options(scenario["trackers"][tracker])
            frame = half_hidden(work.run("{}/{}".format(scene, tracker), folders[scene], options).frames()[0])
            out = work.folder / "pictures" / scene / tracker
            work.run("pictures/{}-{}".format(scene, tracker), [folder], options,
                     ["--pictures", out, "--picture-frames", str(frame)])
            picture = matplotlib.image.imread(out / "{}_step1_{:06d}.png".format(folder.name, frame))
            matplotlib.image.imsave(images / "pixels_{}_{}.jpg".format(scene, tracker), picture, pil_kwargs={"quality": 80})
