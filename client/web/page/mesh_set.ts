import {
  BufferAttribute,
  BufferGeometry,
  InterleavedBuffer,
  InterleavedBufferAttribute,
  Mesh,
  Scene,
  type RawShaderMaterial,
} from "three";
import type { Part } from "./contract";
import type { CoreModel } from "./core_model";

/** Bytes that a frame uploads, so that frames stay short. */
const kUploadBytes = 8e6;
/** Age of a waiting list at which the rest is uploaded at once, so that a moving camera cannot starve it. */
const kLongestWaitMs = 400;

/** A mesh on the GPU. `isDrawn` is false while the list with it is not complete. */
interface Resident {
  mesh: Mesh<BufferGeometry, RawShaderMaterial>;
  index_count: number;
  flags: number;
  tint: number;
}

/**
 * The meshes of one model. Shows one list of parts at a time: while meshes of the next list are uploaded, the
 * shown list stays complete, so that the surface is closed in every frame.
 */
export class MeshSet {
  private residents = new Map<number, Resident>();
  private shown: Part[] = [];
  private waiting: Part[] | null = null;
  private waiting_since_ms = 0;

  constructor(
    private readonly model: CoreModel,
    private readonly scene: Scene,
    private readonly material: RawShaderMaterial,
  ) {}

  get isWaiting(): boolean {
    return this.waiting !== null;
  }

  get partCount(): number {
    return this.shown.length;
  }

  /** Sets the next list to show. Replaces a list that is not complete yet. */
  setParts(parts: Part[]): void {
    if (!this.waiting) this.waiting_since_ms = performance.now();
    this.waiting = parts;
    this.removeUnused();
  }

  /**
   * Uploads meshes of the waiting list, and shows the list once it is complete. Call before each picture.
   * @returns true if the shown list has changed.
   */
  update(): boolean {
    if (!this.waiting) return false;
    const is_late = performance.now() - this.waiting_since_ms > kLongestWaitMs;
    let left = is_late ? Infinity : kUploadBytes;
    for (const [id] of this.waiting) {
      if (this.residents.has(id)) continue;
      if (left <= 0) return false;
      const bytes = this.upload(id);
      if (bytes === null) {
        this.waiting = null; // the core has dropped the mesh: its next list is without it
        this.removeUnused();
        return false;
      }
      left -= bytes;
    }
    this.show(this.waiting);
    return true;
  }

  dispose(): void {
    for (const resident of this.residents.values()) this.remove(resident);
    this.residents.clear();
  }

  private show(parts: Part[]): void {
    this.shown = parts;
    this.waiting = null;
    this.removeUnused();
    for (const [id, flags, tint] of parts) {
      const resident = this.residents.get(id);
      if (!resident) continue;
      resident.flags = flags;
      resident.tint = tint;
      resident.mesh.geometry.setDrawRange(0, resident.index_count);
    }
    const drawn = new Set(parts.map(([id]) => id));
    for (const [id, { mesh }] of this.residents) if (!drawn.has(id)) mesh.geometry.setDrawRange(0, 0);
  }

  /** Creates a mesh with an empty draw range: the next picture uploads it without drawing it. */
  private upload(id: number): number | null {
    const vertices = this.model.meshVertices(id);
    const indices = this.model.meshIndices(id);
    if (!vertices || !indices) return null;
    const stride = this.model.meshStride();
    const geometry = new BufferGeometry();
    const buffer = new InterleavedBuffer(vertices, stride);
    geometry.setAttribute("vertex_words", new InterleavedBufferAttribute(buffer, 4, 0));
    if (stride >= 6) geometry.setAttribute("texture_words", new InterleavedBufferAttribute(buffer, 2, 4));
    const index = new BufferAttribute(indices, 1);
    geometry.setIndex(index);
    geometry.setDrawRange(0, 0);
    const bytes = vertices.byteLength + indices.byteLength;
    // The core keeps the data: the page's copy is freed once it is on the GPU.
    buffer.onUpload(() => (buffer.array = new Uint32Array()));
    index.onUpload(() => (index.array = new Uint32Array()));

    const mesh = new Mesh(geometry, this.material);
    const resident: Resident = { mesh, index_count: indices.length, flags: 0, tint: 0 };
    mesh.frustumCulled = false;
    mesh.matrixAutoUpdate = false;
    mesh.onBeforeRender = () => this.setUniforms(resident);
    this.scene.add(mesh);
    this.residents.set(id, resident);
    return bytes;
  }

  private setUniforms({ flags, tint }: Resident): void {
    const { draw_flags, draw_tint } = this.material.uniforms;
    if (!draw_flags || !draw_tint || (draw_flags.value === flags && draw_tint.value === tint)) return;
    draw_flags.value = flags;
    draw_tint.value = tint;
    this.material.uniformsNeedUpdate = true;
  }

  /** Frees meshes that are neither in the shown nor in the waiting list. */
  private removeUnused(): void {
    const used = new Set([...this.shown, ...(this.waiting ?? [])].map(([id]) => id));
    for (const [id, resident] of this.residents) {
      if (used.has(id)) continue;
      this.remove(resident);
      this.residents.delete(id);
    }
  }

  private remove({ mesh }: Resident): void {
    this.scene.remove(mesh);
    mesh.geometry.dispose();
  }
}
