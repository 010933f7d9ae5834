import assert from "node:assert/strict";
import { test } from "node:test";
import { thresholdIndex, kThresholdsPx } from "../page/settings.ts";
import { formatErrorPx, formatLength, formatUncertainty, progress, statusLine } from "../page/words.ts";

test("the corner names error, triangles and bytes", () => {
  const status = { error_px: 0.97678, triangles: 362818, received_bytes: 1157422 };
  assert.equal(statusLine(status), "0.98 px · 362,818 triangles · 1.2 MB");
});

test("a shown error is never less than the error", () => {
  for (let error = 0.001; error < 5000; error *= 1.37)
    assert.ok(Number.parseFloat(formatErrorPx(error)) >= error * (1 - 1e-9), String(error));
});

test("a length has no digits beyond its uncertainty but one", () => {
  assert.equal(formatLength(1.23456789, 0.001), "1.2346");
  assert.equal(formatLength(123456.789, 20), "123457");
  assert.equal(formatLength(0.123456789012, 1e-12), "0.123456789");
});

test("an uncertainty is rounded up to two digits", () => {
  assert.equal(formatUncertainty(0.00121), "0.0013");
  assert.equal(formatUncertainty(21.01), "22");
  assert.equal(formatUncertainty(0), "0");
});

test("progress grows from almost 0 to 1", () => {
  const at = (error_px) => progress({ error_px, threshold_px: 1, converged: error_px <= 1 }, 64);
  assert.equal(at(0.9), 1);
  assert.equal(at(8), 0.5);
  assert.ok(at(64) > 0 && at(64) < 0.05);
});

test("the slider shows the nearest threshold", () => {
  kThresholdsPx.forEach((px, index) => assert.equal(thresholdIndex(px), index));
  assert.equal(thresholdIndex(0.001), 0);
  assert.equal(thresholdIndex(64), kThresholdsPx.length - 1);
});
