import { Camera, Scene, WebGLRenderer, type IUniform } from "three";
import { makeBackground } from "./background";
import type { FrameAnswer, Part, ShowMode } from "./contract";
import type { CoreModel } from "./core_model";
import { MeshPrograms } from "./mesh_programs";
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

/** Objects that draw a model. The first frame's answer contains the names of the uniforms. */
interface Drawing {
  programs: MeshPrograms;
  meshes: MeshSet;
}

/** Draws a model as the core describes it. */
export class Picture {
  private readonly scene = new Scene();
  private readonly camera = new Camera(); // unused, but required by three.js
  private readonly background = makeBackground();
  private readonly textures: TileTextures;
  private drawing: Drawing | null = null;
  private parts: Part[] = [];
  private features = -1;
  private look = "";

  constructor(
    private readonly model: CoreModel,
    private readonly renderer: WebGLRenderer,
  ) {
    this.textures = new TileTextures(model, renderer);
    this.scene.matrixWorldAutoUpdate = false;
    this.scene.add(this.background);
  }

  /** Number of parts in the picture. */
  get partCount(): number {
    return this.drawing?.meshes.partCount ?? 0;
  }

  /** Ids of the meshes in the picture. */
  get ids(): number[] {
    return this.drawing?.meshes.ids ?? [];
  }

  /** True while meshes of the next list are uploaded: draw again in the next frame. */
  get isWaiting(): boolean {
    return this.drawing?.meshes.isWaiting ?? false;
  }

  /** Draws a frame, unless the picture would be the same. @returns true if it was drawn. */
  draw(answer: FrameAnswer, show: ShowMode, has_changed = false): boolean {
    const { programs, meshes } = (this.drawing ??= this.start(answer));
    const has_new_tiles = this.textures.update();
    const { exist, has_clear } = this.textures;
    const features = programs.featuresOf(show, exist, has_clear);
    if (answer.parts || features !== this.features) {
      this.parts = answer.parts ?? this.parts;
      this.features = features;
      meshes.setParts(this.parts, features);
    }
    const has_uploads = meshes.isWaiting;
    meshes.update();
    const look = JSON.stringify(answer.uniforms);
    if (!has_changed && !has_uploads && !has_new_tiles && look === this.look) return false;
    this.look = look;
    for (const [name, value] of Object.entries(answer.uniforms)) {
      const uniform = programs.uniforms[name];
      if (uniform) uniform.value = value;
    }
    programs.setChanged();
    this.renderer.render(this.scene, this.camera);
    return true;
  }

  dispose(): void {
    this.drawing?.meshes.dispose();
    this.drawing?.programs.dispose();
    this.textures.dispose();
    this.background.geometry.dispose();
    this.background.material.dispose();
  }

  private start(answer: FrameAnswer): Drawing {
    const uniforms: Record<string, IUniform> = {
      draw_flags: { value: 0 },
      draw_tint: { value: 0 },
      tile_layers: { value: this.textures.layers },
      tile_table: { value: this.textures.table },
    };
    for (const [name, value] of Object.entries(answer.uniforms)) uniforms[name] = { value };
    const programs = new MeshPrograms(this.model.core, this.renderer, uniforms);
    return { programs, meshes: new MeshSet(this.model, this.scene, programs) };
  }
}
