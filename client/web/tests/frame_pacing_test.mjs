import assert from "node:assert/strict";
import { test } from "node:test";
import { FramePacing } from "../page/frame_pacing.ts";

/** Runs `count` frames. @returns the factor after the last frame. */
function run(pacing, from_ms, frame_ms, count, moves) {
  for (let i = 1; i <= count; ++i) {
    pacing.update(from_ms + i * frame_ms, moves);
    pacing.measure(from_ms + (i + 1) * frame_ms, frame_ms);
  }
  return pacing.factor;
}

test("a slow moving picture gets coarser, and as fine as asked for at rest", () => {
  const pacing = new FramePacing();
  assert.ok(run(pacing, 0, 100, 10, true) > 2);
  assert.equal(run(pacing, 1000, 100, 7, false), 1);
});

test("a quick picture stays as it is, and a picture that has become quick gets finer", () => {
  const pacing = new FramePacing();
  assert.equal(run(pacing, 0, 16, 60, true), 1);
  const coarse = run(pacing, 1000, 100, 10, true);
  assert.ok(run(pacing, 2000, 16, 20, true) < coarse);
});

test("slow frames at rest, such as those of a model that loads, change nothing", () => {
  const pacing = new FramePacing();
  pacing.update(0, true);
  assert.equal(run(pacing, 1000, 100, 10, false), 1);
});
