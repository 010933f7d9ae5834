import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { test } from "node:test";
import { pathToFileURL } from "node:url";
import { Core } from "../page/core.ts";
import { CoreModel } from "../page/core_model.ts";

const dist = resolve("../dist"); // run.sh runs in the folder of the tests
const { default: createCore } = await import(pathToFileURL(`${dist}/core.js`).href);
const core = new Core(await createCore({ wasmBinary: readFileSync(`${dist}/core.wasm`) }));
const makeModel = () =>
  new CoreModel(core, { model: "any", token: "", memory_bytes: 256e6, seed: 1, has_cache: false });
const size = { width_px: 640, height_px: 360, threshold_px: 1 };

for (const [name, call] of [
  ["frame", (model) => model.frame(0, { ...size, seconds: 0, show: "surface" })],
  ["pick", (model) => model.pick(1, 1)],
  ["project", (model) => model.project([[0, 0, 0]])],
])
  test(`a call of ${name} before the camera throws, and the model goes on`, () => {
    const model = makeModel();
    assert.throws(() => call(model), /the model has no camera yet/);
    assert.equal(model.startCamera({ ...size, up: null, camera: null }), false);
    assert.throws(() => call(model), /the model has no camera yet/);
    assert.equal(model.step(0), null);
    assert.equal(model.wantsConnection(0), true);
    model.close();
  });
