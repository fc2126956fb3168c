#!/usr/bin/env python3
"""Makes the gallery's pictures, NAME.png beside this file, by `plumb film`.

    assets/gallery/make.py PLUMB [NAME ...]

PLUMB is the program; without names, every scene has its picture made anew. Needs Pillow and a Vulkan driver, which may be one
in software.
"""

import math
import pathlib
import subprocess
import sys
import tempfile

from PIL import Image

SIZE = (192, 120)
# Drawn that many times larger, so that edges are smooth.
SMOOTH = 3
# Of each picture.
MOST_BYTES = 10_000

# When a scene is at its best, s; what part of its picture is shown, as the middle of it and how much larger; and parameters.
MOMENTS = {
    "limbs": (0.05, (0.5, 0.53, 1.15), []),
    "pendulum": (0.3, (0.62, 0.42, 1.6), []),
    "rods": (0.8, (0.57, 0.45, 2.4), []),
    "chain": (0.9, (0.64, 0.4, 2.6), []),
    "hanging": (0.01, (0.5, 0.5, 1.0), []),
    "joint_grid": (0.01, (0.52, 0.5, 1.15), []),
    "top": (1.5, (0.5, 0.5, 1.1), []),
    "heavy_top": (0.5, (0.58, 0.45, 1.3), []),
    "incline": (0.3, (0.36, 0.5, 2.0), []),
    "slide_roll": (0.5, (0.44, 0.55, 1.9), []),
    "rolling": (1.0, (0.45, 0.5, 1.3), []),
    "painleve": (0.05, (0.36, 0.52, 2.0), []),
    "bounce": (1.3, (0.47, 0.62, 3.4), []),
    "spheres": (0.3, (0.53, 0.5, 1.5), []),
    "cradle": (0.01, (0.45, 0.62, 1.9), []),
    "wall": (0.01, (0.5, 0.5, 1.1), []),
    "stack": (0.01, (0.5, 0.5, 1.0), []),
    "pyramid": (0.01, (0.5, 0.5, 1.0), []),
    "pyramids": (0.01, (0.53, 0.5, 1.5), []),
    "slab": (0.4, (0.5, 0.5, 1.2), []),
    "column": (0.3, (0.5, 0.5, 1.1), []),
    "boulder": (1.7, (0.5, 0.5, 1.0), []),
    "wrecking_ball": (0.12, (0.5, 0.5, 1.4), []),
    "card_house": (0.01, (0.5, 0.52, 1.0), []),
    "dominoes": (1.3, (0.48, 0.45, 1.3), []),
    "pile": (1.6, (0.5, 0.5, 1.4), []),
    "heap": (1.2, (0.52, 0.65, 2.0), []),
    "terrain": (1.6, (0.5, 0.5, 1.4), []),
    "rain": (1.9, (0.5, 0.5, 1.3), []),
    "washer": (4.0, (0.5, 0.5, 1.2), ["rim=0"]),
    "trees": (2.5, (0.5, 0.5, 1.4), []),
    "junkyard": (2.2, (0.5, 0.5, 1.3), []),
    "convex_pile": (1.5, (0.5, 0.5, 1.3), []),
    "large_world": (0.2, (0.5, 0.5, 1.3), []),
    "far": (0.01, (0.62, 0.5, 1.2), []),
    "four_bar": (0.5, (0.5, 0.47, 2.2), ["n=4"]),
    "bricard": (0.4, (0.5, 0.55, 1.6), []),
    "andrews": (0.01, (0.48, 0.57, 2.2), []),
    "arm": (0.8, (0.49, 0.5, 1.9), []),
    "servo": (0.3, (0.5, 0.5, 1.5), []),
    "stop": (0.2, (0.5, 0.5, 1.5), []),
    "hinge_chain": (0.4, (0.65, 0.4, 2.4), ["n=8"]),
    "bridge": (1.0, (0.52, 0.45, 1.45), []),
    "tower": (0.01, (0.49, 0.55, 1.7), []),
    "car": (0.5, (0.45, 0.5, 1.6), []),
    "ragdolls": (0.5, (0.5, 0.48, 1.6), ["n=4"]),
}


def names(plumb):
    """All built-in scenes, as `plumb scenes` lists them."""
    listing = subprocess.run([plumb, "scenes"], check=True, capture_output=True, text=True).stdout
    return [line.split()[0] for line in listing.splitlines() if not line.startswith(" ")]


def make(plumb, name, folder):
    """Films one moment, cuts out the best of it, scales it down and leaves it as few colors as it takes."""
    seconds, (x, y, larger), parameters = MOMENTS.get(name, (0.01, (0.5, 0.5, 1.0), []))
    with tempfile.TemporaryDirectory() as scratch:
        drawn = pathlib.Path(scratch) / "drawn.png"
        width, height = (math.ceil(SMOOTH * larger) * side for side in SIZE)
        command = [plumb, "film", name, "--seconds", str(seconds), "--size", f"{width}x{height}", "--out", str(drawn)]
        command += [part for parameter in parameters for part in ("-p", parameter)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        left, top = (max(0, min(1 - 1 / larger, middle - 0.5 / larger)) for middle in (x, y))
        box = (left * width, top * height, (left + 1 / larger) * width, (top + 1 / larger) * height)
        picture = Image.open(drawn).convert("RGB").resize(SIZE, Image.LANCZOS, box=box)
    place = folder / f"{name}.png"
    for colors in (192, 128, 96, 64, 48, 32):
        picture.quantize(colors, method=Image.MAXCOVERAGE, kmeans=3, dither=0).save(place, optimize=True)
        if place.stat().st_size <= MOST_BYTES:
            break
    print(f"{place}: {place.stat().st_size} bytes, {colors} colors", flush=True)


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    plumb, asked = sys.argv[1], sys.argv[2:]
    for name in asked or names(plumb):
        make(plumb, name, pathlib.Path(__file__).resolve().parent)


main()
