import assert from "node:assert/strict";
import { test } from "node:test";
import { Scene, RawShaderMaterial } from "three";
import { kTextured, kWireframe } from "../page/contract.ts";
import { MeshSet } from "../page/mesh_set.ts";

/** A model whose meshes have one triangle and 5 MB of vertices each. */
const model = {
  stride: 4,
  meshVertices: () => new Uint32Array(5e6 / 4 - 3),
  meshIndices: () => new Uint32Array([0, 1, 2]),
  meshStride() {
    return this.stride;
  },
};

function makeSet() {
  const scene = new Scene();
  const programs = { with: (features) => Object.assign(new RawShaderMaterial(), { features }), setChanged() {} };
  const set = new MeshSet(model, scene, programs);
  const drawn = () => scene.children.filter((mesh) => mesh.geometry.drawRange.count > 0).length;
  return { scene, set, drawn };
}
const parts = (...ids) => ids.map((id) => [id, 0, 0]);

test("a list is shown once all of its meshes are uploaded, and the list before until then", () => {
  const { set, drawn } = makeSet();
  set.setParts(parts(1), 0);
  assert.equal(set.update(), true);
  assert.equal(drawn(), 1);
  set.setParts(parts(2, 3, 4, 5), 0);
  assert.equal(set.update(), false);
  assert.deepEqual([drawn(), set.partCount, set.isWaiting], [1, 1, true]);
  assert.equal(set.update(), true);
  assert.deepEqual([drawn(), set.partCount, set.isWaiting], [4, 4, false]);
});

test("a newer list replaces a list that is not complete, and keeps the meshes that both have", () => {
  const { scene, set, drawn } = makeSet();
  set.setParts(parts(1, 2, 3), 0);
  assert.equal(set.update(), false);
  const kept = [...scene.children];
  set.setParts(parts(2, 4), 0);
  assert.equal(set.update(), true);
  assert.equal(drawn(), 2);
  assert.ok(scene.children.includes(kept[1]));
});

test("a mesh that comes back is not uploaded again", () => {
  const { scene, set, drawn } = makeSet();
  set.setParts(parts(1), 0);
  set.update();
  const [first] = scene.children;
  set.setParts(parts(2), 0);
  set.update();
  assert.equal(drawn(), 1);
  set.setParts(parts(1), 0);
  set.update();
  assert.equal(first.geometry.drawRange.count, 3);
  assert.equal(drawn(), 1);
});

test("meshes in no list take at most 32 MB, and the oldest are freed first", () => {
  const { scene, set } = makeSet();
  for (let id = 1; id <= 10; ++id) {
    set.setParts(parts(id), 0);
    set.update();
  }
  assert.equal(scene.children.length, 7); // 6 of 5 MB, and the shown one
  const [oldest] = scene.children;
  set.setParts(parts(4), 0);
  set.update();
  assert.equal(oldest.geometry.drawRange.count, 3);
});

test("edges are drawn without indices, and the surface stays until their meshes are uploaded", () => {
  const { scene, set, drawn } = makeSet();
  set.setParts(parts(1), 0);
  set.update();
  set.setParts(parts(1), kWireframe);
  assert.equal(drawn(), 1);
  set.update();
  assert.equal(drawn(), 1);
  assert.equal(scene.children.at(-1).geometry.index, null);
  assert.equal(scene.children.at(-1).geometry.drawRange.count, 3);
});

test("a mesh without texture coordinates is drawn by a program without textures", () => {
  const { scene, set } = makeSet();
  set.setParts(parts(1), kTextured);
  set.update();
  assert.equal(scene.children[0].material.features, 0);
});
