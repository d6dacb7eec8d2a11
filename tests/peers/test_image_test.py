# SPDX-License-Identifier: Apache-2.0
"""The image test passes on renders of one expectation and fails on a planted difference."""

import unittest

import numpy as np

import image_test


def render(scale=1.0, seed=0, replicates=32, patch=1.0):
    random = np.random.default_rng(seed)
    expectation = np.linspace(0.2, 2.0, 48 * 64 * 3).reshape(48, 64, 3)
    expectation[8:16, 8:16] *= patch
    samples = scale * expectation * random.gamma(10.0, 0.1, size=(replicates, 48, 64, 3))
    return samples


class ImageTest(unittest.TestCase):
    def verdict(self, a, b):
        return image_test.compare(image_test.Render.of_replicates(a), image_test.Render.of_replicates(b))

    def test_same(self):
        result = self.verdict(render(seed=1), render(seed=2))
        self.assertTrue(result["passed"], result)
        self.assertGreater(result["pixels"]["ks_p"], 1e-4)

    def test_from_pixels(self):
        a = image_test.from_replicates(render(seed=1))
        ours = image_test.Render.of_pixels(a.mean, a.variance, 32)
        self.assertTrue(image_test.compare(ours, image_test.Render.of_replicates(render(seed=2)))["passed"])

    def test_one_percent_energy(self):
        result = self.verdict(render(seed=1), render(scale=1.01, seed=2))
        self.assertFalse(result["passed"])
        self.assertEqual(result["pixels"]["failed"], 0)  # the mean fails

    def test_one_block(self):
        result = self.verdict(render(seed=1), render(patch=1.2, seed=2))
        self.assertGreater(result["blocks"]["failed"], 0)

    def test_constant_pixels(self):
        a, b = render(seed=1), render(seed=2)
        a[:, 0, 0], b[:, 0, 0] = 1.0, 1.0
        self.assertTrue(self.verdict(a, b)["passed"])
        b[:, 0, 0] = 1.1
        self.assertFalse(self.verdict(a, b)["passed"])


if __name__ == "__main__":
    unittest.main()
