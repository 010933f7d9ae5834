#!/usr/bin/env python3
"""What bench_window.py makes of a flight."""
import unittest

import bench_window


def flown(*laps):
    """Frames of one millisecond a triangle, but for those that took longer: by lap (triangles, milliseconds more)."""
    return {"frames": [{"lap": lap, "triangles": triangles, "work_ms": triangles + more}
                       for lap, frames in enumerate(laps) for triangles, more in frames]}


class OverFit(unittest.TestCase):
    def test_is_of_the_worst_frame_where_there_are_fewer_than_a_hundred(self):
        self.assertAlmostEqual(bench_window.over_fit(flown([(10, 0)] * 98 + [(10, 5)], [(10, 0), (20, 0)])), 1.5)

    def test_leaves_out_the_worst_of_a_hundred_and_one(self):
        self.assertAlmostEqual(bench_window.over_fit(flown([(10, 0)] * 100 + [(10, 5)], [(10, 0), (20, 0)])), 1)

    def test_says_which_lap_has_no_frame(self):
        for lap, frames in ((1, flown([], [(10, 0)])), (2, flown([(10, 0)], []))):
            with self.assertRaisesRegex(SystemExit, f"lap {lap} "):
                bench_window.over_fit(frames)


class OfTheirAims(unittest.TestCase):
    def test_holds_each_frame_to_what_it_was_to_take_itself(self):
        frames = [{"lap": 0, "work_ms": 30, "target_ms": 15}] * 2 + [{"lap": 0, "work_ms": 100, "target_ms": 120}] * 98
        self.assertAlmostEqual(bench_window.over_aim({"frames": frames}), 2)

    def test_is_not_known_where_frames_may_take_what_they_take(self):
        self.assertIsNone(bench_window.over_aim({"frames": [{"lap": 0, "work_ms": 30, "target_ms": 0}]}))


if __name__ == "__main__":
    unittest.main()
