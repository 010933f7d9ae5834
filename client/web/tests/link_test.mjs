import assert from "node:assert/strict";
import { test } from "node:test";
import { formatLink, modelLink, parseLink, withoutToken } from "../page/link.ts";

const camera = { eye: [1.5, -2e-7, 5300123.45678], target: [0, 0, 0], up: [0, 0, 1], fov_y_deg: 45 };

test("a link shows the same picture again", () => {
  const link = parseLink(formatLink("scan 1 & 2, ö+=#", camera, 1.4, "errors"));
  assert.equal(link.model, "scan 1 & 2, ö+=#");
  assert.deepEqual(link.camera, camera);
  assert.equal(link.threshold_px, 1.4);
  assert.equal(link.show, "errors");
});

test("a link never contains a token", () => {
  assert.equal(parseLink(formatLink("m", camera, 1, "surface")).token, null);
});

test("an address without a token keeps the rest of its fragment", () => {
  assert.equal(withoutToken("#token=abc"), "");
  const rest = withoutToken("#model=a%20b&token=abc&eye=1,2,3");
  assert.equal(rest, "#model=a%20b&eye=1,2,3");
});

test("a link whose end was cut off still opens the model", () => {
  const whole = formatLink("m", camera, 1, "surface");
  for (let length = modelLink("m").length; length < whole.length; ++length) {
    const link = parseLink(whole.slice(0, length));
    assert.equal(link.model, "m");
  }
  assert.equal(parseLink("#model=m&eye=1,2&target=0,0,0&up=0,1,0").camera, null);
  assert.equal(parseLink("#model=m&eye=1,2,3,4&target=0,0,0&up=0,1,0").camera, null);
  assert.equal(parseLink("#model=m&eye=1,2,&target=0,0,0&up=0,1,0").camera, null);
});

test("values outside their ranges are ignored", () => {
  for (const px of ["0", "-1", "1e9", "NaN", ""]) assert.equal(parseLink(`#model=m&px=${px}`).threshold_px, null);
  assert.equal(parseLink("#model=m&show=constructor").show, null);
  assert.equal(parseLink("#model=m&eye=1,2,3&target=0,0,0&up=0,1,0&fov=180").camera, null);
});
