"""How far detected grasps, releases and keypoints are from the hand labels of recordings."""

from __future__ import annotations

import argparse

import numpy as np

import sbam
from sbam.errors import SbamError
from sbam.evaluation.key_events import key_event_errors, pooled


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("recordings", nargs="*", help="recordings with labels; default: the built-in ones")
    arguments = parser.parse_args()
    library = sbam.ObjectLibrary.built_in()
    sources = arguments.recordings or ["built-in:pouring", "built-in:rolling"]
    found = []
    for demonstration in sbam.load(sources):
        if not demonstration.labels:
            print(f"{demonstration.name}: no labels")
            continue
        try:
            errors = key_event_errors(demonstration, library)
        except SbamError as error:
            print(f"{demonstration.name}: {error}")
            continue
        found.append(errors)
        with np.printoptions(precision=2, suppress=True):
            print(
                f"{errors.name}: grasps {errors.grasps} s, releases {errors.releases} s, "
                f"label boundaries {np.median(errors.boundaries):.2f} s from a keypoint "
                f"(evenly spaced keypoints: {errors.spacing / 4:.2f} s)"
            )
    if found:
        print("\n| kind | median s | 90 % s | events |\n| --- | --- | --- | --- |")
        for kind, (median, ninety, count) in pooled(found).items():
            print(f"| {kind} | {median:.2f} | {ninety:.2f} | {count} |")


if __name__ == "__main__":
    main()
