#!/usr/bin/python3
"""Tests of the leak detector that decides whether a soak passes, without a server: soak_test.py"""
import random
import unittest

import soak


class Growth(unittest.TestCase):
    LULLS = 30

    def run_that(self, leaks=0, wavers=0, chance=random.Random(1)):
        """Returns simulated values in the lulls of half an hour."""
        return [20e6 + leaks * number / self.LULLS + chance.gauss(0, wavers) for number in range(self.LULLS)]

    def test_a_leak_is_found(self):
        for leak in (0.5e6, 20e6, 300e6):
            self.assertTrue(soak.grows(self.run_that(leak), soak.LEAST_ALLOCATED), leak)
        self.assertTrue(soak.grows(self.run_that(leaks=4, wavers=0.5), soak.LEAST_DESCRIPTORS))

    def test_a_leak_is_found_beside_random_changes(self):
        told = [soak.grows(self.run_that(leaks=0.64e6, wavers=0.1e6), soak.LEAST_ALLOCATED) for _ in range(200)]
        self.assertGreater(sum(told), 190)

    def test_growth_in_the_last_quarter_is_found(self):
        calm = self.run_that(wavers=0.1e6)
        self.assertTrue(soak.grows(calm[:-7] + [6e6 + value for value in calm[-7:]], soak.LEAST_ALLOCATED))

    def test_growth_in_the_first_quarter_is_ignored(self):
        warming = self.run_that()
        warming[:7] = [4e6 + 2e6 * number for number in range(7)]
        self.assertFalse(soak.grows(warming, soak.LEAST_ALLOCATED))

    def test_growth_below_the_minimum_is_ignored(self):
        self.assertFalse(soak.grows(self.run_that(leaks=0.25e6), soak.LEAST_ALLOCATED))

    def test_random_changes_are_no_growth(self):
        told = [soak.grows(self.run_that(wavers=1e6), soak.LEAST_ALLOCATED) for _ in range(1000)]
        self.assertLess(sum(told), 10)

    def test_only_the_minimum_of_each_lull_counts(self):
        watch = soak.Watch(None)
        watch.seconds, watch.lulls = list(range(10)), [(2, 4), (7, 8)]
        self.assertEqual(watch.in_lulls([9, 9, 5, 3, 4, 1, 0, 8, 6, 2]), [3, 6])


if __name__ == "__main__":
    unittest.main()
