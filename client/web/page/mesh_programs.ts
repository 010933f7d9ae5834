import { DoubleSide, GLSL3, RawShaderMaterial, type IUniform, type WebGLRenderer } from "three";
import { kColourMode, kCutOut, kTextured, kWireframe, type ShowMode } from "./contract";
import type { Core } from "./core";
import { shaderText } from "./core_model";

/** The materials of meshes: one per combination of the shaders' features. They share their uniforms. */
export class MeshPrograms {
  private readonly uniforms: Record<string, IUniform> = { draw_flags: { value: 0 }, draw_tint: { value: 0 } };
  private readonly materials = new Map<number, RawShaderMaterial>();
  private readonly has_samples: boolean;

  constructor(
    private readonly core: Core,
    renderer: WebGLRenderer,
  ) {
    this.has_samples = renderer.getContext().getContextAttributes()?.antialias ?? false;
  }

  /**
   * Returns the features for a picture. @param has_clear  true if textures have transparent texels.
   * With multisampling, alpha to coverage draws these; without, the shader discards them.
   */
  featuresOf(show: ShowMode, has_textures: boolean, has_clear: boolean): number {
    let features = has_textures ? kTextured : 0;
    if (has_clear && !this.has_samples) features |= kCutOut;
    if (show !== "surface") features |= kColourMode;
    if (show === "wireframe") features |= kWireframe;
    return features;
  }

  with(features: number): RawShaderMaterial {
    let material = this.materials.get(features);
    if (material) return material;
    material = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: shaderText(this.core, "vertex", features),
      fragmentShader: shaderText(this.core, "fragment", features),
      uniforms: this.uniforms,
      side: DoubleSide,
      alphaToCoverage: (features & (kTextured | kCutOut)) === kTextured,
    });
    this.materials.set(features, material);
    return material;
  }

  /** Sets a uniform. three.js finds the uniforms of a material when it draws it first: set all of them before. */
  set(name: string, value: unknown): void {
    const uniform = this.uniforms[name];
    if (uniform) uniform.value = value;
    else this.uniforms[name] = { value };
  }

  /** Makes three.js upload all uniforms for the next picture. */
  setChanged(): void {
    for (const material of this.materials.values()) material.uniformsNeedUpdate = true;
  }

  dispose(): void {
    for (const material of this.materials.values()) material.dispose();
  }
}
