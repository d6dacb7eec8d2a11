# SPDX-License-Identifier: Apache-2.0
"""Metrics of other packages, as JSON: metrics.py WIDTH HEIGHT REFERENCE TEST [MAP_FOLDER]

The images are raw float32 linear RGB. Keys are missing where their package is: LDR_FLIP, HDR_FLIP, start, stop, count
(flip_evaluator), SSIM, PSNR (skimage). MAP_FOLDER receives the FLIP maps as raw float32 ldr and hdr.
"""
import json
import pathlib
import sys

import numpy


def srgb(linear):
    x = numpy.clip(linear.astype(numpy.float64), 0, 1)
    return numpy.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def flip(reference, test, folder):
    import flip_evaluator

    options = dict(inputsRGB=False, applyMagma=False, computeMeanError=True)
    values = {}
    for kind in ("LDR", "HDR"):
        error_map, mean, parameters = flip_evaluator.evaluate(reference, test, kind, **options)
        values[kind + "_FLIP"] = float(mean)
        error_map.astype(numpy.float32).tofile(folder / kind.lower())
    values.update(start=parameters["startExposure"], stop=parameters["stopExposure"], count=parameters["numExposures"])
    return values


def similarity(reference, test):
    import skimage.metrics

    a, b = srgb(test), srgb(reference)
    weights = numpy.array([0.2126, 0.7152, 0.0722])
    return {
        "SSIM": float(skimage.metrics.structural_similarity(
            a @ weights, b @ weights, data_range=1, gaussian_weights=True, sigma=1.5, use_sample_covariance=False)),
        "PSNR": float(skimage.metrics.peak_signal_noise_ratio(b, a, data_range=1)),
    }


def main():
    width, height = int(sys.argv[1]), int(sys.argv[2])
    reference, test = (numpy.fromfile(f, numpy.float32).reshape(height, width, 3) for f in sys.argv[3:5])
    values = {}
    for measure in (lambda: flip(reference, test, pathlib.Path(sys.argv[5])), lambda: similarity(reference, test)):
        try:
            values.update(measure())
        except ImportError as missing:
            print(missing, file=sys.stderr)
    print(json.dumps(values))


main()
