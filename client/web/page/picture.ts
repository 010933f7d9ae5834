import { Camera, DoubleSide, GLSL3, RawShaderMaterial, Scene, WebGLRenderer, type IUniform } from "three";
import { makeBackground } from "./background";
import type { FrameAnswer } from "./contract";
import type { CoreModel } from "./core_model";
import { MeshSet } from "./mesh_set";
import { TileTextures } from "./tile_textures";

/** Makes a renderer for a canvas. @throws Error if the browser has no WebGL 2. */
export function makeRenderer(canvas: HTMLCanvasElement): WebGLRenderer {
  const renderer = new WebGLRenderer({
    canvas,
    antialias: true,
    alpha: false,
    stencil: false,
    powerPreference: "high-performance",
  });
  renderer.sortObjects = false;
  return renderer;
}

/** Draws a model as the core describes it. */
export class Picture {
  private readonly scene = new Scene();
  private readonly camera = new Camera(); // three.js wants one; the core's uniforms are the camera
  private readonly background = makeBackground();
  private material: RawShaderMaterial | null = null;
  private meshes: MeshSet | null = null;
  private textures: TileTextures | null = null;
  private drawn = "";

  constructor(
    private readonly model: CoreModel,
    private readonly renderer: WebGLRenderer,
  ) {
    this.scene.matrixWorldAutoUpdate = false;
    this.scene.add(this.background);
  }

  /** Number of parts in the picture. */
  get partCount(): number {
    return this.meshes?.partCount ?? 0;
  }

  /** True while meshes of the next list are uploaded: draw again in the next frame. */
  get isWaiting(): boolean {
    return this.meshes?.isWaiting ?? false;
  }

  /** Draws a frame, unless the picture would be the same. @returns true if it was drawn. */
  draw(answer: FrameAnswer, has_changed = false): boolean {
    if (!this.material) this.start(answer);
    if (!this.material || !this.meshes) return false;
    if (answer.parts) this.meshes.setParts(answer.parts);
    const is_waiting = this.meshes.isWaiting;
    this.meshes.update();
    const has_new_tiles = this.textures?.update(answer.textures_serial) ?? false;
    const look = JSON.stringify(answer.uniforms);
    if (!has_changed && !is_waiting && !has_new_tiles && look === this.drawn) return false;
    this.drawn = look;
    for (const [name, value] of Object.entries(answer.uniforms)) {
      const uniform = this.material.uniforms[name];
      if (uniform) uniform.value = value;
    }
    this.material.uniformsNeedUpdate = true;
    this.renderer.render(this.scene, this.camera);
    return true;
  }

  dispose(): void {
    this.meshes?.dispose();
    this.textures?.dispose();
    this.material?.dispose();
    this.background.geometry.dispose();
    this.background.material.dispose();
  }

  /** Makes what depends on the model's attributes and on the names of the uniforms. */
  private start(answer: FrameAnswer): void {
    const uniforms: Record<string, IUniform> = { draw_flags: { value: 0 }, draw_tint: { value: 0 } };
    for (const [name, value] of Object.entries(answer.uniforms)) uniforms[name] = { value };
    const has_textures = this.model.summary()?.has_textures ?? false;
    if (has_textures) {
      this.textures = new TileTextures(this.model, this.renderer);
      uniforms["tile_layers"] = { value: this.textures.layers };
      uniforms["tile_table"] = { value: this.textures.table };
    }
    this.material = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: this.model.shader("vertex"),
      fragmentShader: this.model.shader("fragment"),
      uniforms,
      side: DoubleSide,
      alphaToCoverage: has_textures,
    });
    this.meshes = new MeshSet(this.model, this.scene, this.material);
  }
}
