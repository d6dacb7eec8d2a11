# SPDX-License-Identifier: Apache-2.0
"""Are two renders of one scene the same up to noise? Welch's t per pixel and channel, on block means and on the mean
of the image, each at a level corrected for the number of tests (Sidak). Works on independent replicates.
"""

from dataclasses import dataclass

import numpy as np
from scipy import stats

BLOCK = 8
ALPHA = 0.01  # of the whole family of tests of one kind
MEAN_LIMIT = 3.5  # of the statistic of the image's mean
# Standard error, relative to the value, that is granted to single precision on both sides.
ARITHMETIC = 2e-4


@dataclass
class Estimate:
    """Means with the variance of each mean and its degrees of freedom; arrays of one shape."""

    mean: np.ndarray
    variance: np.ndarray
    freedom: np.ndarray


def from_replicates(replicates):
    """The estimate of a stack (R, ...) of independent renders."""
    count = len(replicates)
    variance = replicates.var(axis=0, ddof=1) / count
    return Estimate(replicates.mean(axis=0), variance, np.full(variance.shape, count - 1.0))


def block_sum(values, size):
    """Sums over size x size blocks of an image (h, w, 3), sizes that are multiples of it."""
    h, w, c = values.shape
    return values.reshape(h // size, size, w // size, size, c).sum(axis=(1, 3))


def pooled(estimate, size):
    """Means over size x size blocks, whose pixels are independent; freedom by Welch and Satterthwaite."""
    n = size * size
    variance = block_sum(estimate.variance, size)
    spread = block_sum(estimate.variance**2 / estimate.freedom, size)
    freedom = np.where(spread > 0, variance**2 / np.where(spread > 0, spread, 1), 1)
    return Estimate(block_sum(estimate.mean, size) / n, variance / n**2, freedom)


@dataclass
class Render:
    """What the test needs of one side: estimates of pixels (h, w, 3), blocks and the mean (3,)."""

    pixels: Estimate
    blocks: Estimate
    image: Estimate

    @staticmethod
    def of_replicates(replicates):
        """From images (R, h, w, 3); pixels may be correlated."""
        blocks = np.stack([block_sum(r, BLOCK) for r in replicates]) / BLOCK**2
        return Render(from_replicates(replicates), from_replicates(
            blocks), from_replicates(replicates.mean(axis=(1, 2))))

    @staticmethod
    def of_pixels(mean, variance, replicates):
        """From the mean and the variance of the mean of pixels that are independent of one another."""
        pixels = Estimate(mean, variance, np.full(mean.shape, replicates - 1.0))
        blocks = pooled(pixels, BLOCK)
        total, spread = variance.sum(axis=(0, 1)), (variance**2 / pixels.freedom).sum(axis=(0, 1))
        count = mean.shape[0] * mean.shape[1]
        freedom = np.where(spread > 0, total**2 / np.where(spread > 0, spread, 1), 1)
        return Render(pixels, blocks, Estimate(mean.mean(axis=(0, 1)), total / count**2, freedom))


def t_values(a, b):
    """Welch's t and degrees of freedom of the entries whose values are not constant on both sides."""
    noisy = (a.variance + b.variance) > 0
    va, vb, fa, fb = a.variance[noisy], b.variance[noisy], a.freedom[noisy], b.freedom[noisy]
    freedom = (va + vb) ** 2 / (va**2 / fa + vb**2 / fb)
    floor = (ARITHMETIC * 0.5 * (np.abs(a.mean[noisy]) + np.abs(b.mean[noisy]))) ** 2
    return (a.mean[noisy] - b.mean[noisy]) / np.sqrt(va + vb + floor), freedom


def family(a, b):
    """The largest |t| against its limit over one family of tests, as a dictionary."""
    t, freedom = t_values(a, b)
    if t.size == 0:
        return {"tests": 0, "worst_t": 0.0, "failed": 0, "p_smallest": 1.0}
    p = 2 * stats.t.sf(np.abs(t), freedom)
    level = -np.expm1(np.log1p(-ALPHA) / t.size)
    return {
        "tests": int(t.size),
        "worst_t": float(np.abs(t).max()),
        "limit_t": float(stats.t.isf(level / 2, np.median(freedom))),
        "failed": int((p < level).sum()),
        "p_smallest": float(p.min()),
        "ks_p": float(stats.kstest(p, "uniform").pvalue),
    }


def constant_pixels_differ(a, b):
    """Pixel-channels without noise on both sides that differ by more than arithmetic explains."""
    constant = (a.variance + b.variance) == 0
    difference = np.abs(a.mean - b.mean)[constant]
    return int((difference > 5 * ARITHMETIC * np.abs(b.mean[constant])).sum())


def compare(ours, theirs):
    """The whole test as a dictionary; `passed` is its verdict, mean ratios are ours / theirs."""
    t, _ = t_values(ours.image, theirs.image)
    ratio = ours.image.mean / theirs.image.mean
    error = np.sqrt(ours.image.variance + theirs.image.variance) / theirs.image.mean
    result = {
        "pixels": family(ours.pixels, theirs.pixels),
        "blocks": family(ours.blocks, theirs.blocks),
        "image_t": [float(x) for x in t],
        "mean_ratio": [float(x) for x in ratio],
        "mean_ratio_error": [float(x) for x in error],
        "constant_pixels_differ": constant_pixels_differ(ours.pixels, theirs.pixels),
    }
    result["passed"] = bool(
        result["pixels"]["failed"] == 0
        and result["blocks"]["failed"] == 0
        and result["constant_pixels_differ"] == 0
        and all(abs(x) < MEAN_LIMIT for x in t)
    )
    return result
