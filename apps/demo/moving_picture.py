#!/usr/bin/env python3
"""Makes the README's moving picture of the video that `make demo` writes.

  moving_picture.py out/demo/overlay.mp4 docs/images/demo.webp [--width 640] [--every 4] [--quality 35]
"""

import argparse

from PIL import Image

import holdfast


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("video")
    parser.add_argument("picture")
    parser.add_argument("--width", type=int, default=640, help="pixels")
    parser.add_argument("--every", type=int, default=4, help="every n-th frame is shown")
    parser.add_argument("--quality", type=int, default=35, help="of WebP, 0 to 100")
    arguments = parser.parse_args()
    pictures, times = [], []
    for frame in holdfast.Video(arguments.video):
        if frame.index % arguments.every:
            continue
        rgb = Image.fromarray(frame.image[: frame.image.shape[0] * 480 // 532, :, ::-1].copy())  # without the figures
        pictures.append(rgb.resize((arguments.width, rgb.height * arguments.width // rgb.width), Image.Resampling.LANCZOS))
        times.append(frame.time)
    milliseconds = round(1000 * (times[-1] - times[0]) / (len(times) - 1))
    pictures[0].save(arguments.picture, save_all=True, append_images=pictures[1:], duration=milliseconds, loop=0,
                     quality=arguments.quality, method=6)


if __name__ == "__main__":
    main()
