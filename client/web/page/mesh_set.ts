import {
  BufferAttribute,
  BufferGeometry,
  InterleavedBuffer,
  InterleavedBufferAttribute,
  Mesh,
  Scene,
  type RawShaderMaterial,
} from "three";
import { kTextured, kWireframe, type Part } from "./contract";
import type { CoreModel } from "./core_model";
import type { MeshPrograms } from "./mesh_programs";

/** Largest number of bytes that a frame uploads, so that frames stay short. */
const kUploadBytes = 8e6;
/** Age at which a waiting list is uploaded at once, because a moving camera keeps replacing the list. */
const kLongestWaitMs = 400;
/** Bytes of meshes that are in no list: those of a turning camera often come back. */
const kSpareBytes = 32e6;
const kTexturedStride = 6; // words per vertex

/** A mesh on the GPU. Its draw range is empty while the shown list does not contain it. */
interface Resident {
  mesh: Mesh<BufferGeometry, RawShaderMaterial>;
  bytes: number;
  count: number; // number of indices, or of vertices without indices
  has_texture: boolean;
  flags: number;
  tint: number;
}

/** Parts to draw, and the features of the shaders that draw them. */
interface PartList {
  parts: Part[];
  features: number;
}

/**
 * The meshes of one model. Shows one list of parts at a time: while meshes of the next list are uploaded, the
 * shown list stays complete, so that the surface is closed in every frame.
 */
export class MeshSet {
  private readonly residents = new Map<string, Resident>();
  private shown: PartList = { parts: [], features: 0 };
  private waiting: PartList | null = null;
  private waiting_since_ms = 0;

  constructor(
    private readonly model: CoreModel,
    private readonly scene: Scene,
    private readonly programs: MeshPrograms,
  ) {}

  get isWaiting(): boolean {
    return this.waiting !== null;
  }

  get partCount(): number {
    return this.shown.parts.length;
  }

  /** Ids of the meshes in the picture. */
  get ids(): number[] {
    return this.shown.parts.map(([id]) => id);
  }

  /** Sets the next list to show. Replaces a list that is not complete yet. */
  setParts(parts: Part[], features: number): void {
    if (!this.waiting) this.waiting_since_ms = performance.now();
    this.waiting = { parts, features };
    this.removeUnused();
  }

  /**
   * Uploads meshes of the waiting list, and shows the list once it is complete. Call before each picture.
   * @returns true if the shown list has changed.
   */
  update(): boolean {
    const list = this.waiting;
    if (!list) return false;
    const is_late = performance.now() - this.waiting_since_ms > kLongestWaitMs;
    let left = is_late ? Infinity : kUploadBytes;
    for (const [id] of list.parts) {
      if (this.residents.has(keyOf(id, list))) continue;
      if (left <= 0) return false;
      left -= this.upload(id, list);
    }
    this.show(list);
    return true;
  }

  dispose(): void {
    for (const resident of this.residents.values()) this.remove(resident);
    this.residents.clear();
  }

  private show(list: PartList): void {
    this.shown = list;
    this.waiting = null;
    this.removeUnused();
    for (const [id, flags, tint] of list.parts) {
      const key = keyOf(id, list);
      const resident = this.residents.get(key);
      if (!resident) continue;
      this.residents.delete(key); // moves the mesh behind those that were shown before
      this.residents.set(key, resident);
      resident.flags = flags;
      resident.tint = tint;
      const features = resident.has_texture ? list.features : list.features & ~kTextured;
      resident.mesh.material = this.programs.with(features);
      resident.mesh.geometry.setDrawRange(0, resident.count);
    }
  }

  /** Creates a mesh with an empty draw range: the next picture uploads it without drawing it. */
  private upload(id: number, list: PartList): number {
    const vertices = this.model.meshVertices(id) ?? new Uint32Array();
    const indices = this.model.meshIndices(id) ?? new Uint32Array();
    const stride = this.model.meshStride(id) || kTexturedStride;
    const has_wires = (list.features & kWireframe) !== 0;
    const words = has_wires ? withoutIndices(vertices, indices, stride) : vertices;
    const geometry = new BufferGeometry();
    const buffer = new InterleavedBuffer(words, stride);
    const has_texture = stride >= kTexturedStride;
    geometry.setAttribute("vertex_words", new InterleavedBufferAttribute(buffer, 4, 0));
    if (has_texture) geometry.setAttribute("texture_words", new InterleavedBufferAttribute(buffer, 2, 4));
    // Frees the page's copy after the upload, because the core keeps the data.
    buffer.onUpload(() => (buffer.array = new Uint32Array()));
    if (!has_wires) {
      const index = new BufferAttribute(indices, 1);
      index.onUpload(() => (index.array = new Uint32Array()));
      geometry.setIndex(index);
    }
    geometry.setDrawRange(0, 0);

    const features = has_texture ? list.features : list.features & ~kTextured;
    const mesh = new Mesh(geometry, this.programs.with(features));
    const bytes = words.byteLength + (has_wires ? 0 : indices.byteLength);
    const resident: Resident = { mesh, bytes, count: indices.length, has_texture, flags: 0, tint: 0 };
    mesh.frustumCulled = false;
    mesh.matrixAutoUpdate = false;
    mesh.onBeforeRender = () => this.setUniforms(resident);
    this.scene.add(mesh);
    this.residents.set(keyOf(id, list), resident);
    return bytes;
  }

  /** Sets the uniforms of a draw call. Otherwise three.js uploads them once per picture. */
  private setUniforms({ mesh, flags, tint }: Resident): void {
    const { draw_flags, draw_tint } = mesh.material.uniforms;
    if (!draw_flags || !draw_tint || (draw_flags.value === flags && draw_tint.value === tint)) return;
    draw_flags.value = flags;
    draw_tint.value = tint;
    this.programs.setChanged();
  }

  /** Hides meshes that are neither in the shown nor in the waiting list, and frees the oldest of them. */
  private removeUnused(): void {
    const used = new Set<string>();
    for (const list of [this.shown, this.waiting])
      for (const [id] of list?.parts ?? []) if (list) used.add(keyOf(id, list));
    const spare = [...this.residents].filter(([key]) => !used.has(key));
    let bytes = spare.reduce((sum, [, resident]) => sum + resident.bytes, 0);
    for (const [key, resident] of spare) {
      resident.mesh.geometry.setDrawRange(0, 0);
      if (bytes <= kSpareBytes) continue;
      bytes -= resident.bytes;
      this.remove(resident);
      this.residents.delete(key);
    }
  }

  private remove({ mesh }: Resident): void {
    this.scene.remove(mesh);
    mesh.geometry.dispose();
  }
}

/** Returns the key of a mesh for a list: lists that show edges need meshes without indices. */
function keyOf(id: number, { features }: PartList): string {
  return (features & kWireframe) !== 0 ? `wires ${id}` : String(id);
}

/** Returns three vertices per triangle, because the edge shader derives the corner from the vertex number. */
function withoutIndices(vertices: Uint32Array, indices: Uint32Array, stride: number): Uint32Array {
  const words = new Uint32Array(indices.length * stride);
  indices.forEach((index, corner) => {
    words.set(vertices.subarray(index * stride, (index + 1) * stride), corner * stride);
  });
  return words;
}
