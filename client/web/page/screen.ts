import { Camera, Scene, WebGLRenderer, type BufferGeometry, type Mesh, type RawShaderMaterial } from "three";
import { makeBackground } from "./background";
import type { Core } from "./core";
import { MeshPrograms } from "./mesh_programs";

/** Largest number of picture pixels per CSS pixel, because more cost time and are hardly visible. */
const kMostPxPerCss = 2;

/** A program of three.js, whose types have only a part of it. */
interface CompiledProgram {
  program: WebGLProgram;
  isReady(): boolean;
  getUniforms(): unknown;
  getAttributes(): unknown;
}

/** Returns the size in pixels of a picture with a size in CSS pixels. */
export function pictureSize(width: number, height: number): [width_px: number, height_px: number] {
  const scale = Math.min(devicePixelRatio || 1, kMostPxPerCss);
  return [Math.max(1, Math.round(width * scale)), Math.max(1, Math.round(height * scale))];
}

/** Makes a renderer with a canvas as large as the window. @throws Error if the browser has no WebGL 2. */
export function makeRenderer(): WebGLRenderer {
  const renderer = new WebGLRenderer({
    canvas: document.createElement("canvas"),
    antialias: true,
    alpha: false,
    stencil: false,
    powerPreference: "high-performance",
  });
  renderer.sortObjects = false;
  // Now, because it waits for the driver, which has little to do yet.
  renderer.setSize(...pictureSize(innerWidth, innerHeight), false);
  // Off, because three.js would wait three times for the driver before the first picture. See check().
  renderer.debug.checkShaderErrors = false;
  return renderer;
}

/**
 * A canvas with its WebGL context and shaders. All models share a screen, because creating a context and
 * compiling shaders takes longer than receiving the first mesh. After a lost context, make a new screen.
 */
export class Screen {
  readonly background: Mesh<BufferGeometry, RawShaderMaterial> = makeBackground();
  readonly programs: MeshPrograms;
  private readonly camera = new Camera(); // unused, but required by three.js
  private readonly checked = new WeakSet<object>();
  private is_disposed = false;

  constructor(
    core: Core,
    private readonly renderer: WebGLRenderer,
  ) {
    this.programs = new MeshPrograms(core, renderer);
    this.compile(this.background);
  }

  get canvas(): HTMLCanvasElement {
    return this.renderer.domElement;
  }

  get gl(): WebGL2RenderingContext {
    return this.renderer.getContext() as WebGL2RenderingContext;
  }

  /** True if the context is lost or the screen disposed. */
  get isLost(): boolean {
    return this.is_disposed || this.gl.isContextLost();
  }

  /** Sets the size in pixels. @returns true if it has changed. */
  resize(width_px: number, height_px: number): boolean {
    if (width_px === this.canvas.width && height_px === this.canvas.height) return false;
    this.renderer.setSize(width_px, height_px, false);
    return true;
  }

  /** Starts to compile the shaders of a picture, and does not wait for the driver. */
  prepare(features: number): void {
    const mesh = this.background.clone();
    mesh.material = this.programs.with(features);
    this.compile(mesh);
  }

  /** @throws Error if the driver refuses a shader. */
  draw(scene: Scene): void {
    this.renderer.render(scene, this.camera);
    this.check();
  }

  /** Tells three.js that other code has changed the state of the context. */
  resetState(): void {
    this.renderer.resetState();
  }

  dispose(): void {
    if (this.is_disposed) return;
    this.is_disposed = true;
    this.programs.dispose();
    this.background.geometry.dispose();
    this.background.material.dispose();
    this.renderer.dispose();
  }

  /**
   * Checks the programs that the driver has linked, and looks their uniforms up, for which three.js would wait in
   * the first picture. @throws Error if the driver refuses a shader.
   */
  check(): void {
    const gl = this.gl;
    for (const shader of (this.renderer.info.programs ?? []) as unknown as CompiledProgram[]) {
      if (this.checked.has(shader) || !shader.isReady()) continue;
      const { program } = shader;
      if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost())
        throw new Error(`WebGL cannot run a shader: ${gl.getProgramInfoLog(program) ?? ""}`);
      shader.getUniforms();
      shader.getAttributes();
      this.checked.add(shader);
    }
  }

  private compile(mesh: Mesh): void {
    this.renderer.compile(mesh, this.camera);
  }
}
